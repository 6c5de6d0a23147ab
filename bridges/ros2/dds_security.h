/// \file
/// DDS Security as in ROS 2 (SROS 2), configured by its environment variables.
#pragma once

#include <filesystem>
#include <string>

#include <dds/dds.h>

namespace palpate::ros2 {

/// Folder of a participant's certificate, key and permissions, with the file names of `ros2 security`. Empty
/// if the participant is not secured.
struct Enclave {
  std::filesystem::path folder;
  std::string notice;  ///< one line for the user if the requested security is not available; else empty

  bool is_secured() const { return !folder.empty(); }
};

/// Returns the enclave ROS_SECURITY_KEYSTORE/enclaves/NAME if ROS_SECURITY_ENABLE is "true", else none.
/// ROS_SECURITY_ENCLAVE_OVERRIDE takes precedence over `name`. Not thread-safe while environment variables
/// are being set. \throws Error if files are missing and ROS_SECURITY_STRATEGY is "Enforce"; otherwise
/// missing files give an unsecured enclave with a notice.
Enclave enclave_of_environment(const std::string& name);

/// Configures authentication, access control and encryption with the files of `enclave`. \pre it is secured
void set_security(dds_qos_t& qos, const Enclave& enclave);

}  // namespace palpate::ros2
