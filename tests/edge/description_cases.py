# SPDX-License-Identifier: Apache-2.0
"""Gripper description files for the tests: small, complete, and with each kind of mistake."""

SMALLEST = """\
name: smallest
tube:
  inner_radius: 4.7625 mm
  wall_thickness: 1/32 in
  length: 500 mm
fibers:
  alpha: 88 deg
  beta: 60 deg
material:
  law: mooney_rivlin
  c1: 130 kPa
  c2: 15 kPa
  density: 0.95 g/cm^3
mount:
  gravity_direction: [1, 0, 0]
limits:
  pressure_max: 16 psi
"""

COMPLETE = """\
name: complete
description: Everything that a file can say
tube:
  inner_radius: 5 mm
  wall_thickness: 1 mm
  length: 40 cm
fibers:
  alpha: 88 deg
  beta: -60 deg
  straight_fiber_radius: 5.5 mm
material:
  law: gent
  shear_modulus: 290 kPa
  extension_limit: 50
  density: 960 kg/m^3
model:
  curvature_form: exact
  pressure_law: uniform
  twist_shear: false
stiffness:
  bending: 4e-4 N m^2
  torsional: 3e-4 N m^2
extra_mass_per_length: 2 g/m
mount:
  gravity_direction: [0, 3, -4]
  gravity_magnitude: 10 m/s^2
  object_axis: [0, 0, -2]
limits:
  pressure_max: 90 kPa
grip:
  turns_required: 1.5
  friction_coefficient: 0.6
"""

STANDARD_PSI = 0.45359237 * 9.80665 / 0.0254**2


UNIFORM = SMALLEST + "model:\n  pressure_law: uniform\n"


def changed(old, new, text=SMALLEST):
    assert text.count(old) == 1
    return text.replace(old, new)


LENGTH = 'a length with its unit, such as "4.7625 mm"'
PRESSURE = 'a pressure with its unit, such as "55 kPa"'
NUMBER = "a plain finite number, such as 1.05 (no unit, no percent)"
NAME = "one line of text, in quotes if it looks like a number"
DIRECTION = "three finite numbers, not all zero, such as [1, 0, 0] (x, y, z of the base frame)"

WRONG_VALUES = {
    "no unit": (
        ("inner_radius: 4.7625 mm", "inner_radius: 4.7625"),
        (
            f'3:17: tube.inner_radius must be {LENGTH} (write "4.7625 mm" or "4.7625 in" or '
            "whichever unit is meant), got 4.7625"
        ),
    ),
    "unknown unit": (
        ("16 psi", "16 pzi"),
        (
            f'17:17: limits.pressure_max must be {PRESSURE} (there is no unit "pzi"; '
            'did you mean "psi"?), got 16 pzi'
        ),
    ),
    "unit of another dimension": (
        ("500 mm", "500 g"),
        f'5:11: tube.length must be {LENGTH} ("g" is a mass, not a length), got 500 g',
    ),
    "percent": (
        ("88 deg", "88 %"),
        (
            '7:10: fibers.alpha must be an angle with its unit, such as "60 deg" '
            '("%" is a ratio, not an angle), got 88 %'
        ),
    ),
    "temperature": (
        ("500 mm", "20 degC"),
        f'5:11: tube.length must be {LENGTH} (there is no unit "degC"), got 20 degC',
    ),
    "a list for a quantity": (
        ("500 mm", "[500, mm]"),
        f"5:11: tube.length must be {LENGTH}, got [500, mm]",
    ),
    "a mapping for a quantity": (
        ("500 mm", "{mm: 500}"),
        f"5:11: tube.length must be {LENGTH}, got {{mm: 500}}",
    ),
    "a truth value for a quantity": (
        ("500 mm", "true"),
        f"5:11: tube.length must be {LENGTH}, got true",
    ),
    "not a number": (("500 mm", ".nan"), f"5:11: tube.length must be {LENGTH}, got .nan"),
    "infinite": (("500 mm", "inf mm"), f"5:11: tube.length must be {LENGTH}, got inf mm"),
    "overflow": (
        ("500 mm", "1e400 mm"),
        f"5:11: tube.length must be {LENGTH}, and finite, got 1e400 mm",
    ),
    "zero": (
        ("500 mm", "0 mm"),
        "5:11: tube.length must be a positive finite number, got 0 mm",
    ),
    "negative": (
        ("inner_radius: 4.7625 mm", "inner_radius: -4.5 mm"),
        "3:17: tube.inner_radius must be a positive finite number, got -4.5 mm",
    ),
    "negative density": (
        ("0.95 g/cm^3", "-1 g/cm^3"),
        "13:12: material.density must be a positive finite number, got -1 g/cm^3",
    ),
    "out of range": (
        ("88 deg", "95 deg"),
        (
            "7:10: fibers.alpha must be an angle from -90 to 90 deg, not 0 "
            "(95 deg, if counted from 0 to 180 deg, is -85 deg here), got 95 deg"
        ),
    ),
    "two fields that do not go together": (
        ("88 deg", "60 deg"),
        (
            "7:10: fibers.alpha, fibers.beta must be angles of two families that cross "
            "(|sin(alpha - beta)| >= 0.0001), got 60 deg, 60 deg"
        ),
    ),
    "two constants that do not go together": (
        ("130 kPa", "-16 kPa"),
        (
            "11:7: material.c1 + material.c2 must be positive, so that the modulus at rest is, "
            "got -16 kPa, 15 kPa"
        ),
    ),
    "a law that there is not": (
        ("mooney_rivlin", "mooney"),
        (
            "10:8: material.law must be one of neo_hookean, mooney_rivlin, yeoh, gent "
            "(did you mean mooney_rivlin?), got mooney"
        ),
    ),
    "a name that is a number": (("smallest", "12"), f"1:7: name must be {NAME}, got 12"),
    "an empty name": (("smallest", '""'), f'1:7: name must be {NAME}, got ""'),
    "a name of two lines": (
        ("smallest", "|\n  two\n  lines"),
        f"1:7: name must be {NAME}, got | two lines",
    ),
    "no direction": (
        ("[1, 0, 0]", "[0, 0, 0]"),
        f"15:22: mount.gravity_direction must be {DIRECTION}, got [0, 0, 0]",
    ),
    "a direction in a plane": (
        ("[1, 0, 0]", "[1, 0]"),
        f"15:22: mount.gravity_direction must be {DIRECTION}, got [1, 0]",
    ),
    "a direction of lists": (
        ("[1, 0, 0]", "[[1], 0, 0]"),
        f"15:22: mount.gravity_direction must be {DIRECTION}, got [[1], 0, 0]",
    ),
    "a direction with units": (
        ("[1, 0, 0]", "[1 m, 0 m, 0 m]"),
        f"15:22: mount.gravity_direction must be {DIRECTION}, got [1 m, 0 m, 0 m]",
    ),
    "a direction that is not finite": (
        ("[1, 0, 0]", "[.inf, 0, 0]"),
        f"15:22: mount.gravity_direction must be {DIRECTION}, got [.inf, 0, 0]",
    ),
    "a direction in words": (
        ("[1, 0, 0]", "fitted"),
        f"15:22: mount.gravity_direction must be {DIRECTION}, got fitted",
    ),
    "an object axis in words": (
        ("[1, 0, 0]", "[1, 0, 0]\n  object_axis: fit"),
        f"16:16: mount.object_axis must be fitted, or {DIRECTION}, got fit",
    ),
    "negative gravity": (
        ("[1, 0, 0]", "[1, 0, 0]\n  gravity_magnitude: -9.81 m/s^2"),
        "16:22: mount.gravity_magnitude must be a non-negative finite number, got -9.81 m/s^2",
    ),
    "meters for millimeters": (
        ("500 mm", "500 m"),
        "5:11: tube.length must be at most 10 m, got 500 m",
    ),
    "enormous gravity": (
        ("[1, 0, 0]", "[1, 0, 0]\n  gravity_magnitude: 1e10 m/s^2"),
        "16:22: mount.gravity_magnitude must be at most 10000 m/s^2, got 1e10 m/s^2",
    ),
    "a truth value in words": (
        ("limits:", "model:\n  twist_shear: yes\nlimits:"),
        "17:16: model.twist_shear must be true or false, got yes",
    ),
    "a truth value in quotes": (
        ("limits:", "model:\n  twist_shear: 'true'\nlimits:"),
        "17:16: model.twist_shear must be true or false, got 'true'",
    ),
    "a form in capitals": (
        ("limits:", "model:\n  curvature_form: EXACT\nlimits:"),
        (
            "17:19: model.curvature_form must be one of first_order, exact (did you mean exact?), "
            "got EXACT"
        ),
    ),
    "a negative stiffness": (
        ("limits:", "stiffness:\n  bending: -1 N m^2\nlimits:"),
        "17:12: stiffness.bending must be a positive finite number, got -1 N m^2",
    ),
    "a negative mass": (
        ("limits:", "extra_mass_per_length: -1 g/m\nlimits:"),
        "16:24: extra_mass_per_length must be a non-negative finite number, got -1 g/m",
    ),
    "a straight fiber on the axis": (
        ("60 deg", "60 deg\n  straight_fiber_radius: 0 mm"),
        "9:26: fibers.straight_fiber_radius must be a positive finite number, got 0 mm",
    ),
    "turns in percent": (
        ("limits:", "grip:\n  turns_required: 105 %\nlimits:"),
        f"17:19: grip.turns_required must be {NUMBER}, got 105 %",
    ),
    "no turns": (
        ("limits:", "grip:\n  turns_required: 0\nlimits:"),
        "17:19: grip.turns_required must be a positive finite number, got 0",
    ),
    "friction in quotes": (
        ("limits:", "grip:\n  friction_coefficient: '0.5'\nlimits:"),
        f"17:25: grip.friction_coefficient must be {NUMBER}, got '0.5'",
    ),
    "a constant of another law": (
        ("c2: 15 kPa", "c2: 15 kPa\n  c3: 1 kPa"),
        "13:7: material.c3 is not a field here; the constants of mooney_rivlin are c1, c2",
    ),
    "a missing constant": (
        ("  c2: 15 kPa\n", ""),
        f"9:1: material.c2 is missing; it must be {PRESSURE}",
    ),
    "a missing field": (
        ("  length: 500 mm\n", ""),
        f"2:1: tube.length is missing; it must be {LENGTH}",
    ),
    "a field without a value": (
        ("length: 500 mm", "length:"),
        f"6:1: tube.length is missing; it must be {LENGTH}",
    ),
    "a missing section": (
        ("limits:\n  pressure_max: 16 psi\n", ""),
        f": limits.pressure_max is missing; it must be {PRESSURE}",
    ),
    "a field that there is not": (
        ("limits:", "limits:\n  presure_max: 16 psi"),
        "17:3: limits.presure_max is not a field here; did you mean limits.pressure_max?",
    ),
    "a field in the wrong section": (
        ("limits:", "limits:\n  density: 1 g/cm^3"),
        "17:3: limits.density is not a field here; did you mean material.density?",
    ),
    "a field given twice": (
        ("length: 500 mm", "length: 500 mm\n  length: 500 mm"),
        "6:3: tube.length is given twice; keep one of the two, here and on line 5",
    ),
}
