"""A search on several processes finds what it finds on one."""

import numpy as np

from oed import parallel_map
from oed.diagnosis.diagnose import diagnose
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, stribeck

FEW = ("stribeck", "torque_offset", "joint_spring")


def test_two_processes_find_what_one_finds(monkeypatch):
    helped = []
    begin = parallel_map._Helper.begin
    monkeypatch.setattr(parallel_map._Helper, "begin", lambda *a: helped.append(1) or begin(*a))
    dataset = data_set(31, extra=stribeck(1.5, 0.15), repetitions=2)
    found = []
    for count in (1, 2):
        monkeypatch.setenv(parallel_map.PROCESSES, str(count))
        found.append(diagnose(dataset, TorqueModel.standard(dataset.robot), names=FEW))
        assert (len(helped) > 5) == (count == 2)
    one, two = found
    assert [e.name for e in one.effects] == ["stribeck"]
    assert two.effects == one.effects
    assert two.unexplained == one.unexplained
    np.testing.assert_array_equal(two.after.parameters, one.after.parameters)
