"""Lines of TOML keys, and the words of a place."""

import tomllib

import pytest

from haptid.support.files.place import Place, key_lines

TEXT = """name = "arm"  # name = "leg"
gravity = [
  0, 0, -9.81,
]
[control_point]
link = "2"
[[joints]]
name = "a"
[joints.parameters]
Kp = { fixed = 1.0 }
[[joints]]
"name" = "b"
parameters.Ks = 1.0
[ joints . parameters.Fs ]
initial = 2.0
"""


@pytest.mark.parametrize(
    ("path", "line", "words"),
    [
        (("name",), 1, "name"),
        (("gravity", 2), 2, "gravity[2]"),
        (("control_point", "link"), 6, "control_point.link"),
        (("joints", 0), 7, "joints[0]"),
        (("joints", 0, "parameters", "Kp", "fixed"), 10, "joints[0].parameters.Kp.fixed"),
        (("joints", 1, "name"), 12, "joints[1].name"),
        (("joints", 1, "parameters", "Ks"), 13, "joints[1].parameters.Ks"),
        (("joints", 1, "parameters", "Fs", "initial"), 15, "joints[1].parameters.Fs.initial"),
        (("joints", 1, "torque_limit"), 11, "joints[1].torque_limit"),
    ],
)
def test_a_key_has_its_line(path, line, words):
    assert tomllib.loads(TEXT)
    place = Place(file="arm.toml", lines=key_lines(TEXT))
    assert str(place.at(*path)) == f"arm.toml, line {line}: {words}"


def test_the_file_alone_and_a_key_without_a_line():
    assert str(Place(file="arm.toml")) == "arm.toml"
    assert str(Place(file="arm.toml").at("links", 1, "mass")) == "arm.toml: links[1].mass"
