# SPDX-License-Identifier: Apache-2.0
"""Compiles actions of the shape of control_msgs, which PyPI does not have: python this_file FOLDER.

The generators and headers come with the ros-jazzy wheels, the compiler is the one that our own
interfaces need. A colcon workspace would do the same in minutes, with wheels that no one has.
"""

import json
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
KINDS = ["rosidl_generator_c", "rosidl_typesupport_c", *SUPPORTS]
PREFIX = Path(sys.prefix)


def compile_control_msgs(folder):
    """Compile into a folder, in a process of its own; return what to put onto the Python path."""
    command = [sys.executable, "-W", "ignore", __file__, str(folder)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "rosidl_generator_py"


def generate(folder):
    """Write the interfaces, their translations, and the sources of each generator."""
    import rosidl_generator_c
    import rosidl_generator_py.generate_py_impl
    import rosidl_generator_type_description
    import rosidl_typesupport_c
    import rosidl_typesupport_fastrtps_c
    import rosidl_typesupport_introspection_c
    from rosidl_adapter.action import convert_action_to_idl
    from rosidl_adapter.msg import convert_msg_to_idl

    files = [Path(name) for name in INTERFACES]
    for path in files:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(INTERFACES[str(path)])
        convert = convert_msg_to_idl if path.suffix == ".msg" else convert_action_to_idl
        convert(folder, PACKAGE, path, folder / path.parent)
    idl = [path.with_suffix(".idl") for path in files]
    arguments = {
        "package_name": PACKAGE,
        "idl_tuples": [f"{folder}:{path}" for path in idl],
        "target_dependencies": [],
        "include_paths": [f"{path.name}:{path}" for path in (PREFIX / "share").iterdir()],
        "ros_interface_files": [str(folder / path) for path in files],
        "type_description_tuples": [f"{p}:{folder / p.with_suffix('.json')}" for p in idl],
    }
    for generator, *more in (
        (rosidl_generator_type_description.generate_type_hash,),
        (rosidl_generator_c.generate_c,),
        (rosidl_typesupport_fastrtps_c.generate_typesupport_fastrtps_c,),
        (rosidl_typesupport_introspection_c.generate_c,),
        (rosidl_typesupport_c.generate_c, SUPPORTS),
        (rosidl_generator_py.generate_py_impl.generate_py, ["rosidl_typesupport_c"]),
    ):
        name = generator.__module__.split(".")[0]
        first = name == "rosidl_generator_type_description"
        arguments["output_dir"] = str(folder if first else folder / name / PACKAGE)
        arguments["template_dir"] = str(PREFIX / "share" / name / "resource")
        file = folder / f"{name}.json"
        file.write_text(json.dumps(arguments))
        generator(str(file), *more)


def build(folder):
    """Compile all into one library, with the names of all that are looked for."""
    import numpy

    places = [PREFIX / "include", *(PREFIX / "include").iterdir(), sysconfig.get_path("include")]
    places += [numpy.get_include(), *folder.glob("rosidl_*")]
    flags = ["-O0", "-fPIC", "-w", *(f"-I{place}" for place in places)]
    for name in KINDS:
        flags += [f"-D{name.upper()}_{kind}_{PACKAGE}=" for kind in ("EXPORT", "PUBLIC", "IMPORT")]
        header = folder / name / PACKAGE / "msg" / f"{name}__visibility_control.h"
        header.parent.mkdir(parents=True, exist_ok=True)
        header.touch()  # what it exports, the flags say

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
    needed = [
        f"{name}__{kind}"
        for name in DEPENDENCIES.split()
        for kind in (*KINDS, "rosidl_generator_py")
    ]
    needed += [*KINDS[1:], f"{SUPPORTS[0]}pp", "rosidl_runtime_c", "fastcdr", "rcutils"]
    flags = [f"-L{PREFIX / 'lib'}", f"-L{package}", f"-Wl,-rpath,{PREFIX / 'lib'}:{package}"]
    libraries = [f"-l{name}" for name in needed]
    for i, name in enumerate(names):  # the first holds all
        parts = [f"-l:{before}" for before in names[:i]] or objects
        command = ["g++", "-shared", f"-Wl,-soname,{name}", "-o", str(package / name)]
        subprocess.run([*command, *flags, "-Wl,--no-as-needed", *parts, *libraries], check=True)


if __name__ == "__main__":
    generate(Path(sys.argv[1]).resolve())
    build(Path(sys.argv[1]).resolve())
