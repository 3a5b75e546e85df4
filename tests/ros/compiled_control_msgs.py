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
DEPENDENCIES = ("action_msgs", "builtin_interfaces", "sensor_msgs", "service_msgs", "std_msgs",
                "unique_identifier_msgs")  # fmt: skip
SUPPORTS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
EXPORTS = ("ROSIDL_GENERATOR_C", *(support.upper() for support in SUPPORTS))
PREFIX = Path(sys.prefix)


def compile_control_msgs(folder):
    """Compile into a folder, in a process of its own; return what to put onto the Python path."""
    command = [sys.executable, "-W", "ignore", __file__, str(folder)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "rosidl_generator_py"


def _translate(folder):
    """Write the interfaces and their translations; return the latter, as rosidl names them."""
    from rosidl_adapter.action import convert_action_to_idl
    from rosidl_adapter.msg import convert_msg_to_idl

    for name, text in INTERFACES.items():
        path = Path(name)
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
        convert = convert_msg_to_idl if path.suffix == ".msg" else convert_action_to_idl
        convert(folder, PACKAGE, path, folder / path.parent)
    return [f"{folder}:{Path(name).with_suffix('.idl')}" for name in INTERFACES]


def _generate(folder):
    """Write the sources, each generator into a folder of its own."""
    import rosidl_generator_c
    import rosidl_generator_py.generate_py_impl
    import rosidl_generator_type_description
    import rosidl_typesupport_c
    import rosidl_typesupport_fastrtps_c
    import rosidl_typesupport_introspection_c

    idl = _translate(folder)
    shares = [f"{path.name}:{path}" for path in (PREFIX / "share").iterdir() if path.is_dir()]
    names = [Path(name) for name in INTERFACES]
    descriptions = [f"{n.with_suffix('.idl')}:{folder / n.with_suffix('.json')}" for n in names]
    runs = (
        (rosidl_generator_type_description.generate_type_hash, ()),
        (rosidl_generator_c.generate_c, ()),
        (rosidl_typesupport_fastrtps_c.generate_typesupport_fastrtps_c, ()),
        (rosidl_typesupport_introspection_c.generate_c, ()),
        (rosidl_typesupport_c.generate_c, (SUPPORTS,)),
        (rosidl_generator_py.generate_py_impl.generate_py, (["rosidl_typesupport_c"],)),
    )
    for generate, more in runs:
        name = generate.__module__.split(".")[0]
        first = name == "rosidl_generator_type_description"
        arguments = {
            "package_name": PACKAGE,
            "output_dir": str(folder if first else folder / name / PACKAGE),
            "template_dir": str(PREFIX / "share" / name / "resource"),
            "idl_tuples": idl,
            "target_dependencies": [],
            "include_paths": shares,
            "ros_interface_files": [str(folder / name) for name in INTERFACES],
            "type_description_tuples": descriptions,
        }
        file = folder / f"{name}.json"
        file.write_text(json.dumps(arguments))
        generate(str(file), *more)


def _compile(folder):
    """Compile every source, two at a time; return the objects by generator."""
    import numpy

    for name in ("rosidl_generator_c", *SUPPORTS):  # what they export, the flags below say
        (folder / name / PACKAGE / "msg" / f"{name}__visibility_control.h").touch()
    places = [PREFIX / "include", *(PREFIX / "include").iterdir(), sysconfig.get_path("include")]
    places += [numpy.get_include(), *folder.glob("rosidl_*")]
    flags = ["-O0", "-fPIC", "-w", *(f"-I{place}" for place in places)]
    flags += [f"-D{name}_{kind}_{PACKAGE}=" for name in EXPORTS for kind in ("EXPORT", "PUBLIC")]
    flags += [f"-D{name}_IMPORT_{PACKAGE}=" for name in EXPORTS]
    objects, running = {}, []
    for number, source in enumerate(sorted(folder.glob("rosidl_*/**/*.c*"))):
        target = folder / f"{number}.o"
        objects.setdefault(source.relative_to(folder).parts[0], []).append(str(target))
        compiler = ["gcc"] if source.suffix == ".c" else ["g++", "-std=c++17"]
        command = [*compiler, *flags, "-c", str(source), "-o", str(target)]
        running.append(subprocess.Popen(command))
        if len(running) == (os.cpu_count() or 1):
            _finish(running)
    _finish(running)
    return objects


def _finish(running):
    """Wait for all; fail if one has failed."""
    codes = [process.wait() for process in running]
    if any(codes):
        raise SystemExit("a source of control_msgs does not compile")
    running.clear()


def _link(folder, objects):
    """Link what the dispatcher loads by name, then the extension module that brings both along."""
    package = folder / "rosidl_generator_py" / PACKAGE
    kinds = ("rosidl_generator_c", "rosidl_typesupport_c", *SUPPORTS)
    libraries = [f"-l{name}__{kind}" for name in DEPENDENCIES for kind in kinds]
    libraries += [f"-l{name}__rosidl_generator_py" for name in DEPENDENCIES]
    libraries += [f"-l{name}" for name in ("rosidl_typesupport_c", *SUPPORTS, "rosidl_runtime_c")]
    libraries += ["-lrosidl_typesupport_fastrtps_cpp", "-lfastcdr", "-lrcutils"]
    flags = [f"-L{PREFIX / 'lib'}", f"-L{package}", f"-Wl,-rpath,{PREFIX / 'lib'}:{package}"]
    own = [f"lib{PACKAGE}__{name}.so" for name in ("rosidl_generator_c", *SUPPORTS)]
    base = objects["rosidl_generator_c"]
    pieces = [base, *(objects[support] for support in SUPPORTS)]
    extension = f"{PACKAGE}_s__rosidl_typesupport_c{sysconfig.get_config_var('EXT_SUFFIX')}"
    pieces.append(objects["rosidl_typesupport_c"] + objects["rosidl_generator_py"])
    for i, (name, files) in enumerate(zip([*own, extension], pieces, strict=True)):
        command = ["g++", "-shared", f"-Wl,-soname,{name}", "-o", str(package / name), *files]
        needed = [f"-l:{before}" for before in own[:i]]
        subprocess.run([*command, *flags, "-Wl,--no-as-needed", *needed, *libraries], check=True)


if __name__ == "__main__":
    target = Path(sys.argv[1]).resolve()
    _generate(target)
    _link(target, _compile(target))
