#include "dds_security.h"

#include <dlfcn.h>

#include <array>
#include <cstdlib>
#include <system_error>

#include <fmt/format.h>

#include <palpate/base/error.h>

namespace palpate::ros2 {
namespace {

namespace fs = std::filesystem;

/// A property of a participant (DDS Security 1.1, 8.4.2 and 9), and the file that it names.
struct SecurityFile {
  const char* property;
  const char* name;
};
constexpr std::array<SecurityFile, 6> kFiles{{
    {"dds.sec.auth.identity_ca", "identity_ca.cert.pem"},
    {"dds.sec.auth.identity_certificate", "cert.pem"},
    {"dds.sec.auth.private_key", "key.pem"},
    {"dds.sec.access.permissions_ca", "permissions_ca.cert.pem"},
    {"dds.sec.access.governance", "governance.p7s"},
    {"dds.sec.access.permissions", "permissions.p7s"},
}};

/// Security plug-in of Cyclone DDS.
struct SecurityLibrary {
  const char* kind;      ///< part of its property names
  const char* library;   ///< without "lib" and ".so"
  const char* function;  ///< function names without "init_" and "finalize_"
};
constexpr std::array<SecurityLibrary, 3> kLibraries{{
    {"auth", "dds_security_auth", "authentication"},
    {"access", "dds_security_ac", "access_control"},
    {"crypto", "dds_security_crypto", "crypto"},
}};

std::string variable(const char* name) {
  // No code here sets environment variables. NOLINTNEXTLINE(concurrency-mt-unsafe)
  const char* text = std::getenv(name);
  return text == nullptr ? "" : text;
}

/// Path of a security plug-in: Debian has them in a subfolder beside the library, which the loader does not
/// search.
std::string path_of(const char* library) {
  Dl_info at{};
  if (dladdr(reinterpret_cast<const void*>(&dds_create_participant), &at) == 0) return library;
  const fs::path own(at.dli_fname);
  std::string folder = own.filename().string();  // libddsc.so.0debian: libddsc0debian
  if (const std::size_t so = folder.find(".so."); so != std::string::npos) folder.erase(so, 4);
  const fs::path path = own.parent_path() / folder / fmt::format("lib{}.so", library);
  std::error_code ignored;
  return fs::exists(path, ignored) ? path.string() : library;
}

/// Reason why `folder` is not an enclave; empty if it is one.
std::string missing_in(const fs::path& folder) {
  std::error_code ignored;
  for (const SecurityFile& file : kFiles)
    if (!fs::exists(folder / file.name, ignored))
      return fmt::format("{} does not exist", printable((folder / file.name).string()));
  return {};
}

}  // namespace

Enclave enclave_of_environment(const std::string& name) {
  if (variable("ROS_SECURITY_ENABLE") != "true") return {};
  const std::string keystore = variable("ROS_SECURITY_KEYSTORE"),
                    other = variable("ROS_SECURITY_ENCLAVE_OVERRIDE");
  const std::string inside = other.empty() ? name : other;
  const fs::path folder = fs::path(keystore) / "enclaves" / fs::path(inside).relative_path();
  const std::string missing = keystore.empty() ? "ROS_SECURITY_KEYSTORE is not set" : missing_in(folder);
  if (missing.empty()) return {folder, {}};
  if (variable("ROS_SECURITY_STRATEGY") == "Enforce")
    throw Error("ROS_SECURITY_ENABLE: {}; create the enclave {} with `ros2 security create_enclave`", missing,
                printable(inside));
  return {{},
          fmt::format(
              "NOT SECURED although ROS_SECURITY_ENABLE is true: {}; with ROS_SECURITY_STRATEGY=Enforce the "
              "program ends instead",
              missing)};
}

void set_security(dds_qos_t& qos, const Enclave& enclave) {
  for (const SecurityFile& file : kFiles)
    dds_qset_prop(&qos, file.property, ("file:" + (enclave.folder / file.name).string()).c_str());
  for (const SecurityLibrary& library : kLibraries) {
    const std::string key = fmt::format("dds.sec.{}.library.", library.kind);
    dds_qset_prop(&qos, (key + "path").c_str(), path_of(library.library).c_str());
    dds_qset_prop(&qos, (key + "init").c_str(), fmt::format("init_{}", library.function).c_str());
    dds_qset_prop(&qos, (key + "finalize").c_str(), fmt::format("finalize_{}", library.function).c_str());
  }
}

}  // namespace palpate::ros2
