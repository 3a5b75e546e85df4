# SPDX-License-Identifier: Apache-2.0
"""Compiles actions of the shape of control_msgs, which PyPI does not have: python this_file FOLDER.

The generators and headers come with the ros-jazzy wheels, the compiler is the one that our own
interfaces need. A colcon workspace would do the same in minutes, with wheels that no one has.
"""

import os
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

PACKAGE = "control_msgs"
# The fields of the real package, without its comments.
INTERFACES = {
    "msg/GripperCommand.msg": "float64 position\nfloat64 max_effort\n",
    "action/GripperCommand.action": (
        "GripperCommand command\n"
        "---\nfloat64 position\nfloat64 effort\nbool stalled\nbool reached_goal\n"
        "---\nfloat64 position\nfloat64 effort\nbool stalled\nbool reached_goal\n"
    ),
    "action/ParallelGripperCommand.action": (
        "sensor_msgs/JointState command\n"
        "---\nsensor_msgs/JointState state\nbool stalled\nbool reached_goal\n"
        "---\nsensor_msgs/JointState state\n"
    ),
}
DEPENDENCIES = """
action_msgs builtin_interfaces sensor_msgs service_msgs std_msgs unique_identifier_msgs
"""
SUPPORTS = ["rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c"]
RUNTIME = "rosidl_runtime_c fastcdr rcutils"
PREFIX = Path(sys.prefix)


def compile_control_msgs(folder):
    """Compile into a folder, in a process of its own; return what to put onto the Python path."""
    command = [sys.executable, "-W", "ignore", __file__, str(folder)]
    environment = {**os.environ, "AMENT_PREFIX_PATH": sys.prefix}
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
    return folder / "rosidl_generator_py"


def generate(folder):
    """Write the interfaces, their translations, and the sources of each generator."""
    from rosidl_adapter.action import convert_action_to_idl
    from rosidl_adapter.msg import convert_msg_to_idl
    from rosidl_generator_c.cli import GenerateC
    from rosidl_generator_py.cli import GeneratePython
    from rosidl_generator_type_description.cli import HashTypeDescription
    from rosidl_typesupport_c.cli import GenerateCTypesupport
    from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
    from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

    given = PACKAGE, [], [str(PREFIX / "share")]
    for name, text in INTERFACES.items():
        path = Path(name)
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
        convert = convert_msg_to_idl if path.suffix == ".msg" else convert_action_to_idl
        convert(folder, PACKAGE, path, folder / path.parent)
        given[1].append(f"{folder}:{path.with_suffix('.idl')}")
    HashTypeDescription("").generate_type_hashes(*given, folder)
    for one in given[1]:  # names of messages and actions are alike
        described = [one.replace(":", "/").replace(".idl", ".json")]
        place = folder / "rosidl_generator_c" / PACKAGE
        GenerateC("").generate(PACKAGE, [one], given[2], place, described)
    for kind in (
        GenerateCTypesupport(""),
        GenerateFastRTPSCTypesupport(""),
        GenerateIntrospectionCTypesupport(""),
        GeneratePython("", typesupport_implementations=["rosidl_typesupport_c"]),
    ):
        kind.generate(*given, folder / kind.__module__.partition(".")[0] / PACKAGE)


def build(folder):
    """Compile all into one library, with the names of all that are looked for."""
    import numpy

    places = [PREFIX / "include", *(PREFIX / "include").iterdir(), sysconfig.get_path("include")]
    places += [numpy.get_include(), *folder.glob("rosidl_*")]
    flags = ["-O0", "-fPIC", "-w", *(f"-I{place}" for place in places)]

    def compiled(source):
        command = ["gcc", *flags, "-c", str(source), "-o", f"{source}.o"]
        subprocess.run(command, check=True)
        return f"{source}.o"

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(compiled, folder.glob("rosidl_*/**/*.c*")))
    package = folder / "rosidl_generator_py" / PACKAGE
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    names = [f"lib{PACKAGE}__{name}.so" for name in SUPPORTS]
    names.append(f"{PACKAGE}_s__rosidl_typesupport_c{suffix}")
    built = [(PREFIX / "lib").glob(f"lib{name}__*.so") for name in DEPENDENCIES.split()]
    needed = [library.stem.removeprefix("lib") for found in built for library in found]
    needed += ["rosidl_typesupport_c", *SUPPORTS, f"{SUPPORTS[0]}pp", *RUNTIME.split()]
    flags = [f"-L{PREFIX / 'lib'}", f"-L{package}", f"-Wl,-rpath,{PREFIX / 'lib'}:{package}"]
    libraries = [f"-l{name}" for name in needed]
    for i, name in enumerate(names):  # the first holds all
        parts = [f"-l:{before}" for before in names[:i]] or objects
        command = ["g++", "-shared", f"-Wl,-soname,{name}", "-o", str(package / name)]
        subprocess.run([*command, *flags, "-Wl,--no-as-needed", *parts, *libraries], check=True)


if __name__ == "__main__":
    generate(Path(sys.argv[1]).resolve())
    build(Path(sys.argv[1]).resolve())
