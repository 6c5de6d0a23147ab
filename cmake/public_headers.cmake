# Headers for applications. Only these and the headers that they include are installed.
set(palpate_public_headers
  base/clock.h base/error.h base/progress.h base/real_time.h base/version.h
  geometry/ellipsoid.h geometry/pose.h geometry/rotation.h geometry/similarity.h
  kinematics/chain_file.h kinematics/inverse_kinematics.h kinematics/joint_motion.h
  scene/lint.h scene/load_scene.h scene/ply_writer.h scene/scene_filter.h scene/scene_setup.h
  collision/batch_query.h collision/contact_columns.h collision/contact_tracker.h collision/ellipsoid_lookup.h collision/index_file.h collision/lookahead.h
  collision/open_index.h collision/paper_pipeline.h collision/scene_index.h
  haptics/density_force.h haptics/field_force.h haptics/zero_order_hold.h haptics/material_file.h haptics/proxy_force.h haptics/settled_force.h haptics/tool_file.h
  haptics/tool_query.h
  servo/admittance_loop.h servo/haptic_device.h servo/live_view.h servo/safety_governor.h servo/servo_loop.h servo/servo_tick.h
  record/playback.h record/recorder.h record/run_log.h record/trajectory.h
  device/device_plugin.h device/export_device.h device/giant_device.h device/giant_plant.h device/giant_setup.h device/hand_path.h
  device/playback_device.h device/profiles.h device/simulated_device.h device/testing/device_contract.h device/testing/scripted_device.h
  study/procedural.h study/still_life.h study/touch_path.h
  live/config_toml.h live/factories.h live/live_gateway.h live/live_hands.h live/live_system.h)

# Sets `result` to `headers` and all headers of src/palpate that they include.
function(palpate_with_included headers result)
  set(found)
  while(headers)
    list(POP_FRONT headers header)
    if(NOT header IN_LIST found)
      list(APPEND found ${header})
      file(STRINGS ${PROJECT_SOURCE_DIR}/src/palpate/${header} lines REGEX "^#include <palpate/")
      list(TRANSFORM lines REPLACE "^#include <palpate/([^>]*)>.*" "\\1")
      list(APPEND headers ${lines})
    endif()
  endwhile()
  set(${result} ${found} PARENT_SCOPE)
endfunction()
