# SPDX-License-Identifier: Apache-2.0
# Read by `pip install .` only (CMAKE_PROJECT_INCLUDE in /pyproject.toml), after project() of
# spiral_gripper_msgs. Puts what ros2 run and ros2 launch look up where colcon would put it.
include(${CMAKE_CURRENT_LIST_DIR}/ros_wheels.cmake)

foreach(_package spiral_core spiral_gripper spiral_gripper_ros)
  set(_folder ${CMAKE_CURRENT_LIST_DIR}/../${_package})
  install(FILES ${_folder}/resource/${_package} DESTINATION share/ament_index/resource_index/packages)
  install(FILES ${_folder}/package.xml DESTINATION share/${_package})
  foreach(_part config launch rviz security systemd urdf)
    if(EXISTS ${_folder}/${_part})
      install(DIRECTORY ${_folder}/${_part} DESTINATION share/${_package} PATTERN __pycache__ EXCLUDE)
    endif()
  endforeach()
endforeach()
foreach(_executable spiral_gripper_node spiral_gripper_demo spiral_gripper_regulator spiral_gripper_simulator)
  install(PROGRAMS ${CMAKE_CURRENT_LIST_DIR}/ros2_run_stub.sh
    DESTINATION lib/spiral_gripper_ros RENAME ${_executable})
endforeach()
