#include <palpate/gateway/crtk_options.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string_view>

#include <palpate/base/error.h>

namespace palpate {
namespace {

constexpr double kWeakest = 3.3;  // N, of a Touch, the weakest commercial device
/// More than any haptic device has; a larger number has another unit. Unit: [N].
constexpr double kStrongest = 1000.0;
/// A driver that has died is felt for three periods: 0.15 s. Unit: [Hz].
constexpr double kLeastRate = 20.0;

struct NumberOption {
  std::string_view name;
  double& (*place)(CrtkOptions& options);
};

constexpr std::array<NumberOption, 11> kNumbers{{
    {"force_max", [](CrtkOptions& o) -> double& { return o.capabilities.force_max; }},
    {"force_sustained", [](CrtkOptions& o) -> double& { return o.capabilities.force_sustained; }},
    {"torque_max", [](CrtkOptions& o) -> double& { return o.capabilities.torque_max; }},
    {"stiffness_max", [](CrtkOptions& o) -> double& { return o.capabilities.stiffness_max; }},
    {"damping", [](CrtkOptions& o) -> double& { return o.capabilities.damping; }},
    {"damping_max", [](CrtkOptions& o) -> double& { return o.capabilities.damping_max; }},
    {"angular_damping", [](CrtkOptions& o) -> double& { return o.capabilities.angular_damping; }},
    {"workspace", [](CrtkOptions& o) -> double& { return o.capabilities.workspace; }},
    {"rate", [](CrtkOptions& o) -> double& { return o.capabilities.rate; }},
    {"delay", [](CrtkOptions& o) -> double& { return o.capabilities.delay; }},
    {"one_way", [](CrtkOptions& o) -> double& { return o.one_way; }},
}};

double number_of(const std::string& where, const std::string& text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number) || number < 0.0)
    throw Error("{}: '{}' is not a number >= 0", where, printable(text));
  return number;
}

/// \param digits whether tokens may begin with a digit: in names of ROS 1, but not of ROS 2
bool is_prefix(const std::string& text, bool digits) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  bool begins = false;  // a token, at c
  for (const char c : text) {
    const bool fits = is_letter(c) || (is_digit(c) && (digits || !begins)) || (c == '/' && !begins);
    if (!fits) return false;
    begins = c == '/';
  }
  return text.size() > 1 && text[0] == '/' && !begins;
}

/// What check_capabilities() cannot know to be a mistake.
void check_units(const std::string& where, const DeviceCapabilities& can) {
  if (can.force_max > kStrongest)
    throw Error("{}: force_max must be at most {} N; correct its unit", where, kStrongest);
  if (can.rate < kLeastRate)
    throw Error(
        "{}: rate must be at least {} Hz, since the force ends only after three missing poses; correct its "
        "unit, or the driver",
        where, kLeastRate);
}

void set(const std::string& where, CrtkOptions& options, const std::string& name, const std::string& value) {
  if (name == "frame") {
    options.frame = value;
    return;
  }
  if (name == "extrapolation") {
    options.extrapolation = number_of(where, value);
    return;
  }
  const auto at =
      std::find_if(kNumbers.begin(), kNumbers.end(), [&](const NumberOption& o) { return o.name == name; });
  if (at == kNumbers.end())
    throw Error("{}: there is no option '{}'; docs/ros.md lists them", where, printable(name));
  at->place(options) = number_of(where, value);
}

}  // namespace

CrtkArguments parse_crtk_arguments(const std::string& kind, const std::string& text) {
  std::stringstream parts(text);
  CrtkArguments result;
  std::getline(parts, result.prefix, ',');
  const std::string where = "--device " + kind + ":" + printable(text);
  if (!is_prefix(result.prefix, kind == "ros1"))
    throw Error("{}: needs the prefix of the device's topics, such as {}:/omni for /omni/measured_cp", where,
                kind);
  DeviceCapabilities& can = result.options.capabilities;
  can.name = kind + ":" + result.prefix;
  can.force_max = kWeakest;
  for (std::string part; std::getline(parts, part, ',');) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos) throw Error("{}: '{}' is not NAME=VALUE", where, printable(part));
    set(where, result.options, part.substr(0, equals), part.substr(equals + 1));
  }
  if (can.torque_max > 0.0) can.actuated.rotation = 3;
  if (can.damping > 0.0 || can.angular_damping > 0.0) can.damping_source = DampingSource::kMeasured;
  check_capabilities(can);
  check_units(where, can);
  return result;
}

}  // namespace palpate
