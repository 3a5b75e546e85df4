# SPDX-License-Identifier: Apache-2.0
from spiral_gripper.files.catalog import available_grippers as available_grippers
from spiral_gripper.files.description import GripperDescription as GripperDescription
from spiral_gripper.files.description import load_description as load_description
from spiral_gripper.files.description import load_gripper as load_gripper
from spiral_gripper.files.description_text import save_description as save_description
from spiral_gripper.files.errors import DescriptionError as DescriptionError
from spiral_gripper.files.errors import Problem as Problem
from spiral_gripper.files.errors import ProblemKind as ProblemKind
from spiral_gripper.files.shown import display_units as display_units
from spiral_gripper.files.tubing import Tubing as Tubing
from spiral_gripper.files.tubing import available_tubing as available_tubing
from spiral_gripper.files.tubing import load_tubing as load_tubing
from spiral_gripper.files.tubing import parse_tube_size as parse_tube_size
from spiral_gripper.files.units import Dimension as Dimension
from spiral_gripper.files.units import convert_from_si as convert_from_si
from spiral_gripper.files.units import parse_quantity as parse_quantity
from spiral_gripper.pictures import plot as plot
