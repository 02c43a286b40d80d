"""Signs of what a log holds: of a joint, or of one of its quantities."""

import numpy as np
import pytest

from oed.experiment.importing.import_log import ImportChoices, propose_import

T = np.arange(0, 4, 0.01)


@pytest.mark.parametrize(
    ("sign", "q", "tau"),
    [((-1.0, 1.0), -1.0, -1.0), ({"tau": (-1.0, 1.0)}, 1.0, -1.0), ((), 1.0, 1.0)],
)
def test_a_sign_is_of_all_of_a_joint_or_of_its_torque(sign, q, tau, tmp_path):
    log = tmp_path / "log.csv"
    columns = (T, np.sin(3 * T), np.cos(2 * T), 5 * np.sin(3 * T + 0.1), 2 * np.cos(2 * T + 0.1))
    header = "t,q_1,q_2,tau_1,tau_2"
    np.savetxt(log, np.column_stack(columns), delimiter=",", header=header, comments="")
    choices = ImportChoices(robot="builtin:imi_scara", sign=sign, torque="measured")
    found = propose_import([log], choices, tmp_path / "out").dataset.recordings[0]
    rows = slice(0, len(found.t))
    assert found.q[:, 0] == pytest.approx(q * columns[1][rows])
    assert found.tau[:, 0] == pytest.approx(tau * columns[3][rows])
    assert found.tau[:, 1] == pytest.approx(columns[4][rows])
