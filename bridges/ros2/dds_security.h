/// \file
/// DDS Security as ROS 2 has it (SROS 2): which files, from the usual environment variables.
#pragma once

#include <filesystem>
#include <string>

#include <dds/dds.h>

namespace palpate::ros2 {

/// Where a participant's certificate, key and permissions are, under the names that `ros2 security` gives
/// them. None: it is not secured.
struct Enclave {
  std::filesystem::path folder;
  std::string
      notice;  ///< one line for a person where security was asked for and is not to be had; else empty

  bool is_secured() const { return !folder.empty(); }
};

/// Secured if ROS_SECURITY_ENABLE is "true": ROS_SECURITY_KEYSTORE/enclaves/NAME, where
/// ROS_SECURITY_ENCLAVE_OVERRIDE goes before `name`. Not thread-safe beside who sets variables. \throws Error
/// where files are missing and ROS_SECURITY_STRATEGY is "Enforce"; else the enclave says so.
Enclave enclave_of_environment(const std::string& name);

/// Has Cyclone DDS authenticate, decide and encrypt by the files of `enclave`. \pre it is secured
void set_security(dds_qos_t& qos, const Enclave& enclave);

}  // namespace palpate::ros2
