"""A model that is written and read again is the same model."""

import dataclasses
import json

import jsonschema
import msgspec
import numpy as np
import pytest

import oed
from oed.dynamics.effects import Effect, Parameter
from oed.dynamics.torque_model import TorqueModel
from oed.export.model import Model
from oed.export.model_file import load_model, write_model
from oed.export.model_record import ModelFileError, model_schema
from tests.dynamics.effects.arms import panda, scara, smooth_motion
from tests.export.every_effect import EFFECTS, ORIGIN, model_with
from tests.paths import REPO

SCHEMA = REPO / "docs/reference/model.schema.json"


def written(model, folder):
    return write_model(model, folder / "model.json")


def same_torque(model, again, motion):
    before, after = (m.torque_model.torque(m.parameters, motion) for m in (model, again))
    return np.abs(after - before).max() <= 1e-12 * np.abs(before).max()


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_comes_back(tmp_path, name):
    model, motion = model_with(name)
    again = load_model(written(model, tmp_path))
    assert same_torque(model, again, motion)
    assert [type(e) for e in again.torque_model.effects] == [
        type(e) for e in model.torque_model.effects
    ]
    assert again.torque_model.parameters == model.torque_model.parameters
    assert model.covariance is not None
    assert again.covariance is not None
    assert np.array_equal(again.covariance, np.where(model.estimated, model.covariance, 0))


def test_all_effects_and_free_forms_together_come_back(tmp_path):
    model, motion = model_with(*EFFECTS, forms=True)
    path = written(model, tmp_path)
    assert same_torque(model, load_model(path), motion)
    again = load_model(written(load_model(path), tmp_path / "again"))
    assert same_torque(model, again, motion)


def test_a_robot_with_a_file_keeps_it(tmp_path):
    robot = panda()
    motion = smooth_motion(robot, 0.2)
    model, _ = model_with("stribeck", robot=robot, duration=0.5)
    again = load_model(written(model, tmp_path))
    assert same_torque(model, again, motion)
    assert again.robot.description is not None
    assert robot.description is not None
    assert again.robot.description.text == robot.description.text
    assert again.robot.description.path.resolve() == robot.description.path.resolve()
    for kind in ("position", "velocity", "torque"):
        assert np.array_equal(getattr(again.robot.limits, kind), getattr(robot.limits, kind))


def test_what_is_known_of_the_numbers_comes_back(tmp_path):
    model, _ = model_with("stribeck")
    again = oed.load_model(written(model, tmp_path))
    assert again.origin == model.origin
    assert model.validity is not None
    assert again.validity is not None
    assert np.array_equal(again.validity.tau, model.validity.tau)
    assert again.std == pytest.approx(model.std, nan_ok=True)


@pytest.mark.parametrize("names", [(), EFFECTS])
def test_files_keep_to_their_schema(tmp_path, names):
    plain = json.loads(written(model_with(*names)[0], tmp_path).read_text(encoding="utf-8"))
    jsonschema.validate(plain, model_schema())


def test_the_schema_in_the_documentation_is_that_of_the_types():
    assert json.loads(SCHEMA.read_text(encoding="utf-8")) == json.loads(
        msgspec.json.encode(model_schema())
    )


@dataclasses.dataclass(frozen=True)
class Wobble(Effect):
    """A user's own."""

    joint: int
    depth: tuple[float, ...]
    name = "wobble"

    @property
    def parameters(self):
        return tuple(Parameter(f"w{k}_{self.joint + 1}", "N m", self.joint) for k in (1, 2))

    @property
    def depends_on(self):
        return (f"q_{self.joint + 1}",)

    def entries(self, state):
        return [{self.joint: state.q[self.joint] ** d} for d in self.depth]


def test_an_effect_from_outside_comes_back(tmp_path):
    robot = scara()
    torque_model = TorqueModel(robot, (Wobble(1, (2.0, 3.0)),))
    model = Model(torque_model, np.array([1.5, -2.0]), None, np.ones(2, bool), False, None, ORIGIN)
    path = written(model, tmp_path)
    assert same_torque(model, load_model(path), smooth_motion(robot, 0.1))
    renamed = path.read_text(encoding="utf-8").replace('"Wobble"', '"Wibble"')
    path.write_text(renamed, encoding="utf-8")
    with pytest.raises(ModelFileError, match=r"no effect 'Wibble' here.*import the module"):
        load_model(path)


def _spoiled(text, how):
    plain = json.loads(text)
    how(plain)
    return json.dumps(plain)


def _drop_a_joint(plain):
    plain["robot"]["joints"].pop()


def _change(*keys, to):
    def change(plain):
        for key in keys[:-1]:
            plain = plain[key]
        plain[keys[-1]] = to

    return change


SPOILED = {
    "older": (_change("version", to=0), "has version 0 of the format"),
    "newer": (_change("version", to=2), "make it again"),
    "foreign": (_change("format", to="urdf"), "is no model.json"),
    "a word for a number": (
        _change("effects", 1, "parameters", 0, "value", to="much"),
        r"effects\[1\].parameters\[0\].value",
    ),
    "an unknown field": (_change("colour", to="red"), "colour"),
    "a joint too few": (_drop_a_joint, "robot"),
    "another name": (
        _change("effects", 1, "parameters", 0, "name", to="Fx"),
        r"effects\[1\]: its parameters are Fx",
    ),
    "an impossible shape": (_change("effects", -1, "form", "speed", to=-1.0), "positive"),
    "a field of no effect": (
        _change("effects", -1, "form", "spin", to=1.0),
        "has no spin in this version",
    ),
    "a joint that carries itself": (_change("robot", "joints", 0, "parent", to=0), "no way leads"),
    "a joint on nothing": (_change("robot", "joints", 1, "parent", to=7), "no way leads"),
    "two joints of one name": (
        _change("robot", "joints", 1, "name", to="joint_1"),
        "two joints are called 'joint_1'",
    ),
    "an axis without a direction": (
        _change("robot", "joints", 0, "axis", to=[0.0, 0.0, 0.0]),
        "joint joint_1: its axis has length 0",
    ),
    "a mirror for a rotation": (
        _change("robot", "joints", 0, "R_PJ", to=np.diag([1.0, 1.0, -1.0]).tolist()),
        "R_PJ is no rotation",
    ),
    "limits of one joint": (
        _change("robot", "limits", "torque", to=[[-1.0, 1.0]]),
        "torque limits of 1 joints",
    ),
    "nested without end": (
        _change("effects", 1, "form", "spin", to=json.loads("[" * 900 + "]" * 900)),
        "nested too deeply",
    ),
    "a joint that the arm lacks": (
        _change("effects", -1, "form", "joint", to=7),
        "cannot be evaluated",
    ),
    "a word for a joint": (
        _change("effects", -1, "form", "joint", to="first"),
        r"effects\[\d\].joint: Expected `int`, got `str`",
    ),
    "true for a joint": (
        _change("effects", -1, "form", "joint", to=True),
        r"effects\[\d\].joint: Expected `int`, got `bool`",
    ),
    "true for a width": (
        _change("effects", -1, "form", "speed", to=True),
        r"effects\[\d\].speed: Expected `float`, got `bool`",
    ),
    "a width that divides to infinity": (
        _change("effects", -1, "form", "speed", to=1e-320),
        r"effects\[\d\].form.speed: a number 9.99989e-321 is beyond",
    ),
    "a mass of no arm": (
        _change("robot", "inertials", 0, to=-1e200),
        r"robot.inertials\[0\]: a number -1e\+200 is beyond",
    ),
    "a value of a thousand digits": (
        _change("effects", 1, "parameters", 0, "value", to=10**1000),
        r"effects\[1\].parameters\[0\].value: a number of 3322 bits is beyond",
    ),
    "a robot of true and false": (
        _change("effects", 0, "form", "robot", to={"robot": {"gravity": [0.0, True, -9.81]}}),
        r"effects\[0\].robot: Expected `float`, got `bool`",
    ),
    "an array of words": (
        _change("effects", -1, "form", "speed", to={"array": ["much"]}),
        r"effects\[\d\].speed: \['much'\] is no array of numbers",
    ),
    "a kind that is no word": (_change("effects", -1, "form", "type", to=[]), "there is no effect"),
    "a joint without a name": (_change("robot", "joints", 0, "name", to=" "), "give it a name"),
    "a joint of two lines": (_change("robot", "joints", 0, "name", to="a\nb"), "give it a name"),
    "a negative variance": (
        _change("covariance", "matrix", 0, 0, to=-1.0),
        "covariance is damaged: no errors",
    ),
    "a covariance that is not symmetric": (
        _change("covariance", "matrix", 0, 1, to=1e9),
        "covariance is damaged: no errors",
    ),
    "covariance of another size": (_change("covariance", "matrix", to=[[1.0]]), "covariance"),
}


@pytest.mark.parametrize("how", SPOILED)
def test_a_spoiled_file_is_refused_in_one_line(tmp_path, how):
    change, words = SPOILED[how]
    path = written(model_with("stribeck")[0], tmp_path)
    path.write_text(_spoiled(path.read_text(encoding="utf-8"), change), encoding="utf-8")
    with pytest.raises(ModelFileError, match=words) as caught:
        load_model(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"{", b"[1, 2]", b"\xff\xfe", b"null", b"[" * 100_000])
def test_what_is_no_model_is_refused(tmp_path, content):
    path = tmp_path / "model.json"
    path.write_bytes(content)
    with pytest.raises(ModelFileError, match=r"model\.json: (is no model|not JSON)"):
        load_model(path)
    with pytest.raises(ModelFileError, match="no such file"):
        load_model(tmp_path / "absent.json")


def test_a_spoiled_robot_text_is_noticed(tmp_path):
    model, _ = model_with(robot=panda(), duration=0.1)
    path = written(model, tmp_path)
    spoiled = _spoiled(
        path.read_text(encoding="utf-8"), _change("robot", "description", "text", to="<robot/>")
    )
    path.write_text(spoiled, encoding="utf-8")
    with pytest.raises(ModelFileError, match="sha256"):
        load_model(path)


def test_an_estimate_starts_from_physics_and_leaves_shapes_as_they_are():
    model, motion = model_with("stribeck", "time_delay", forms=True)
    fitted, known = model.to_estimate()
    assert not any(effect.name == "smooth_term" for effect in fitted.effects)
    assert fitted.measurement == model.torque_model.measurement
    whole = dataclasses.replace(fitted, effects=(*fitted.effects, *known.effects))
    parameters = [*model.parameters[: len(fitted.parameters)], *known.parameters]
    expected = model.torque_model.torque(model.parameters, motion)
    assert whole.torque(np.array(parameters), motion) == pytest.approx(expected, rel=1e-12)
