#include <palpate/device/plugin_device.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <type_traits>

#include <dlfcn.h>
#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/device/device_plugin.h>

namespace palpate {
namespace {

constexpr std::string_view kPathPrefix = "plugin:";
constexpr std::string_view kExtension = ".so";

// Layout that both sides rely on, whatever compiled them.
static_assert(sizeof(PalpateDeviceCapabilities) == 184 && sizeof(PalpateDeviceReading) == 120 &&
              sizeof(PalpateDeviceWrench) == 48);
static_assert(std::is_trivial_v<PalpateDevicePlugin> && sizeof(PalpateDevicePlugin) == 104);
static_assert(static_cast<int>(DeviceStatus::kFault) == PALPATE_DEVICE_FAULT &&
              static_cast<int>(DampingSource::kSimulated) == PALPATE_DAMPING_SIMULATED);

/// Error message of a plug-in.
using ErrorText = std::array<char, 512>;

std::string text_of(ErrorText& text) {
  text.back() = '\0';
  std::string line = text.data();
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line.empty() ? "it gave no reason" : line;
}

Eigen::Vector3d vector_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

class PluginDevice final : public HapticDevice {
 public:
  PluginDevice(std::string path, const PalpateDevicePlugin& plugin, const std::string& arguments)
      : path_(std::move(path)), plugin_(plugin) {
    ErrorText error{};
    device_ = plugin_.create(arguments.c_str(), error.data(), error.size());
    if (device_ == nullptr) throw Error("{}: {}", path_, text_of(error));
  }
  ~PluginDevice() override { plugin_.destroy(device_); }

  void open() override {
    call(plugin_.open);
    PalpateDeviceCapabilities can{};
    plugin_.capabilities(device_, &can);
    take(can);
    copy_status();
  }
  void calibrate() override {
    if (plugin_.calibrate == nullptr)
      throw Error("{}: needs calibration, but has no function for it; correct the plug-in", path_);
    call(plugin_.calibrate);
    copy_status();
  }
  void enable() override {
    call(plugin_.enable);
    copy_status();
  }
  void close() noexcept override {
    plugin_.close(device_);
    set_status(DeviceStatus::kClosed);
  }

  const DeviceCapabilities& capabilities() const override { return capabilities_; }

  bool read(double t, DeviceReading& reading) override {
    PalpateDeviceReading said{};
    const bool is_new = plugin_.read(device_, t, &said) == 1;
    copy_status();
    if (!is_new) return false;
    const auto& q = said.orientation;
    reading.t = said.t;
    reading.pose = {vector_of(said.position), Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
    reading.velocity = {vector_of(said.linear_velocity), vector_of(said.angular_velocity)};
    reading.hand = said.hand;
    reading.buttons = said.buttons;
    return true;
  }

  void wait(const LoopClock& clock, double until) override {
    const double left = until - clock.now();
    if (plugin_.wait == nullptr) {
      clock.sleep_until(until);
    } else if (left > 0.0) {
      plugin_.wait(device_, left);
    }
  }

  void write(const Wrench& wrench) override {
    const Eigen::Vector3d &f = wrench.force, &m = wrench.torque;
    const PalpateDeviceWrench sent{{f.x(), f.y(), f.z()}, {m.x(), m.y(), m.z()}};
    plugin_.write(device_, &sent);
  }

  void stop() noexcept override { plugin_.stop(device_); }

 private:
  void call(int (*function)(void*, char*, std::size_t)) {
    ErrorText error{};
    if (function(device_, error.data(), error.size()) != 0) throw Error("{}: {}", path_, text_of(error));
  }

  /// Copies the plug-in's status, for callers that do not query the plug-in.
  void copy_status() {
    const char* text = "";
    const int status = plugin_.status(device_, &text);
    const bool known = status >= PALPATE_DEVICE_CLOSED && status <= PALPATE_DEVICE_FAULT;
    set_status(known ? static_cast<DeviceStatus>(status) : DeviceStatus::kFault,
               !known            ? "the plug-in returned an unknown status"
               : text == nullptr ? ""
                                 : text);
  }

  void take(const PalpateDeviceCapabilities& can) {
    DeviceCapabilities& c = capabilities_;
    c.name.assign(can.name, std::find(std::begin(can.name), std::end(can.name), '\0'));
    if (c.name.empty()) c.name = path_;
    c.force_max = can.force_max;
    c.torque_max = can.torque_max;
    c.force_sustained = can.force_sustained;
    c.torque_sustained = can.torque_sustained;
    c.stiffness_max = can.stiffness_max;
    c.damping_max = can.damping_max;
    c.damping = can.damping;
    c.angular_damping = can.angular_damping;
    const bool known = can.damping_source >= 0 && can.damping_source <= PALPATE_DAMPING_SIMULATED;
    c.damping_source = known ? static_cast<DampingSource>(can.damping_source) : DampingSource::kUnknown;
    c.delay = can.delay;
    c.watchdog = can.watchdog;
    c.workspace = can.workspace;
    c.rate = can.rate;
    c.sensed = {can.sensed_translation, can.sensed_rotation};
    c.actuated = {can.actuated_translation, can.actuated_rotation};
  }

  std::string path_;
  const PalpateDevicePlugin& plugin_;
  void* device_ = nullptr;
  DeviceCapabilities capabilities_;
};

bool is_complete(const PalpateDevicePlugin& p) {
  return p.create != nullptr && p.destroy != nullptr && p.open != nullptr && p.enable != nullptr &&
         p.close != nullptr && p.capabilities != nullptr && p.read != nullptr && p.write != nullptr &&
         p.stop != nullptr && p.status != nullptr;
}

const PalpateDevicePlugin& load(const std::string& path) {
  if (!std::filesystem::is_regular_file(path))
    throw Error("{}: there is no such file; give the path of a device plug-in", printable(path));
  // By path, not by the loader's search for a bare name.
  void* library = ::dlopen(std::filesystem::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL);
  // glibc keeps the message per thread. NOLINTNEXTLINE(concurrency-mt-unsafe)
  if (library == nullptr) throw Error("{}: cannot be loaded: {}", printable(path), ::dlerror());
  const auto entry =
      reinterpret_cast<decltype(&palpate_device_plugin)>(::dlsym(library, PALPATE_DEVICE_PLUGIN_SYMBOL));
  if (entry == nullptr)
    throw Error("{}: is not a device plug-in: it does not export {}", printable(path),
                PALPATE_DEVICE_PLUGIN_SYMBOL);
  const PalpateDevicePlugin* plugin = entry(PALPATE_DEVICE_PLUGIN_VERSION);
  if (plugin == nullptr || plugin->version != PALPATE_DEVICE_PLUGIN_VERSION) {
    throw Error("{}: uses {} of the plug-in interface, this program version {}; recompile it",
                printable(path),
                plugin == nullptr ? "another version" : fmt::format("version {}", plugin->version),
                PALPATE_DEVICE_PLUGIN_VERSION);
  }
  if (plugin->size != sizeof(PalpateDevicePlugin) || !is_complete(*plugin))
    throw Error("{}: lacks a required function; see palpate/device/device_plugin.h", printable(path));
  return *plugin;
}

/// Path of a plug-in: beside the program in the build tree, in lib if installed.
std::string file_of(const std::string& name) {
  const std::string file = fmt::format("palpate_device_{}{}", name, kExtension);
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::filesystem::path beside = program / file;
  const std::filesystem::path installed = program.parent_path() / "lib" / "palpate" / file;
  for (const std::filesystem::path& path : {beside, installed})
    if (std::filesystem::exists(path)) return path.string();
  throw Error("--device {}: there is no {} in {} or {}; install it there, or give plugin:PATH.so", name, file,
              beside.parent_path().string(), installed.parent_path().string());
}

bool is_name(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

}  // namespace

std::unique_ptr<HapticDevice> make_plugin_device(const std::string& path, const std::string& arguments) {
  return std::make_unique<PluginDevice>(printable(path), load(path), arguments);
}

bool names_plugin(const std::string& text) {
  const std::size_t colon = text.find(':');
  return colon != std::string::npos && is_name(text.substr(0, colon));
}

std::unique_ptr<HapticDevice> make_plugin_device(const std::string& text) {
  if (!names_plugin(text))
    throw Error("--device {}: is neither plugin:PATH.so nor NAME:ARGUMENTS", printable(text));
  if (!text.starts_with(kPathPrefix)) {
    const std::size_t colon = text.find(':');
    return make_plugin_device(file_of(text.substr(0, colon)), text.substr(colon + 1));
  }
  const std::string rest = text.substr(kPathPrefix.size());
  const std::size_t end = rest.find(std::string(kExtension) + ":");
  if (end == std::string::npos) return make_plugin_device(rest, "");
  const std::size_t path = end + kExtension.size();
  return make_plugin_device(rest.substr(0, path), rest.substr(path + 1));
}

}  // namespace palpate
