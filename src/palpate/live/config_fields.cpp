#include <palpate/live/config_fields.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/base/error.h>
#include <palpate/device/plugin_device.h>
#include <palpate/device/profiles.h>
#include <palpate/geometry/unit_quaternion.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/live/value_text.h>
#include <palpate/rosbridge/access.h>
#include <palpate/scene/material_properties.h>

namespace palpate {
namespace {

using enum ConfigGroup;

constexpr double kMostForce = 1e6;
constexpr double kMostDetail = 10.0;  // m

Eigen::Vector3d vector_of(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

/// Field of an enumeration; `names` are in the order of its enumerators.
template <class Field, std::size_t N>
ChoiceField choice(const std::array<std::string_view, N>& names, Field) {
  return {{names.begin(), names.end()},
          [](const LiveConfig& c) { return static_cast<std::size_t>(Field{}(c)); },
          [](LiveConfig& c, std::size_t chosen) {
            auto& place = Field{}(c);
            place = static_cast<std::remove_reference_t<decltype(place)>>(chosen);
          }};
}

template <class Field>
NumbersField rotation(Field) {
  return {.count = 4,
          .get = [](const LiveConfig& c) { return numbers(Field{}(c)); },
          .set = [](LiveConfig& c, const std::vector<double>& q) { Field{}(c) = parse_quaternion(q.data()); },
          .unit_norm = true,
          .most_parameter = kQuaternionMax};
}

template <class Field>
NumbersField vector(Field) {
  return {.count = 3,
          .get = [](const LiveConfig& c) { return numbers(Field{}(c)); },
          .set = [](LiveConfig& c, const std::vector<double>& v) { Field{}(c) = vector_of(v); },
          .shows_default = true,
          .most_parameter = kCoordinateMax};
}

NumbersField crop_box() {
  return {.count = 6,
          .get =
              [](const LiveConfig& c) {
                const auto& box = c.scene.filter.crop_box;
                if (!box) return std::vector<double>{};
                std::vector<double> corners = numbers(box->min());
                for (const double v : numbers(box->max())) corners.push_back(v);
                return corners;
              },
          .set =
              [](LiveConfig& c, const std::vector<double>& v) {
                const Eigen::AlignedBox3d box(vector_of(v), Eigen::Vector3d(v[3], v[4], v[5]));
                if (box.isEmpty()) throw BadValue("the first corner must be below the second");
                c.scene.filter.crop_box = box;
              },
          .most_parameter = kCoordinateMax,
          .unset = [](LiveConfig& c) { c.scene.filter.crop_box.reset(); }};
}

NumbersField crop_sphere() {
  return {.count = 4,
          .get =
              [](const LiveConfig& c) {
                const auto& sphere = c.scene.filter.crop_sphere;
                if (!sphere) return std::vector<double>{};
                std::vector<double> all = numbers(sphere->center);
                all.push_back(sphere->radius);
                return all;
              },
          .set =
              [](LiveConfig& c, const std::vector<double>& v) {
                if (!(v[3] > 0.0)) throw BadValue("the radius must be positive");
                c.scene.filter.crop_sphere = SceneFilter::Sphere{vector_of(v), v[3]};
              },
          .most_parameter = kCoordinateMax,
          .unset = [](LiveConfig& c) { c.scene.filter.crop_sphere.reset(); }};
}

NumbersField hand() {
  return {
      .count = 3,
      .get =
          [](const LiveConfig& c) {
            const HandProperties& held = c.device.hand;
            return std::vector<double>{held.mass, held.damping, held.stiffness};
          },
      .set = [](LiveConfig& c, const std::vector<double>& mbk) { c.device.hand = parse_hand(mbk.data()); },
      .shows_default = true};
}

ChoiceField device() {
  ChoiceField field = choice(
      kDeviceKindNames, [](auto& c) -> auto& { return c.device.kind; });
  field.other = [](auto& c) -> auto& { return c.device.driver; };
  field.may_be = names_plugin;
  return field;
}

ChoiceField profile() {
  std::vector<std::string_view> names;
  for (const DeviceProfile& known : device_profiles()) names.push_back(known.capabilities.name);
  return {
      std::move(names),
      [](const LiveConfig& c) {
        const std::vector<std::string> all = profile_names();
        return static_cast<std::size_t>(std::find(all.begin(), all.end(), c.device.profile) - all.begin());
      },
      [](LiveConfig& c, std::size_t chosen) { c.device.profile = profile_names()[chosen]; }};
}

// clang-format off
std::vector<ConfigField> make_fields() {
  return {
    {"opacity-min", "filter.opacity_min", kScene, "alpha", "keep Gaussians with opacity above this",
     NumberField{[](auto& c) -> auto& { return c.scene.filter.opacity_min; }, 0.0, 1.0}, {.saved = true}},
    {"sigma", "filter.sigma", kScene, "k", "ellipsoid size in standard deviations",
     NumberField{[](auto& c) -> auto& { return c.scene.filter.sigma; }, SceneFilter::kSigmaMin, SceneFilter::kSigmaMax}, {.saved = true}},
    {"iso", "filter.iso", kScene, "tau", "ellipsoid size from the visible opacity level tau instead: k = sqrt(2 ln(alpha/tau))",
     OptionalField{[](auto& c) -> auto& { return c.scene.filter.iso; }, 1.0}, {.saved = true, .read_only = true, .excludes = "sigma"}},
    {"max-scale", "filter.max_scale", kScene, "m", "drop Gaussians with a longest standard deviation above this, m",
     OptionalField{.member = [](auto& c) -> auto& { return c.scene.filter.max_scale; }, .most_parameter = kCoordinateMax}, {.saved = true}},
    {"crop-box", "filter.crop_box", kScene, "x0,y0,z0,x1,y1,z1", "keep Gaussians with centres inside this box, world frame, m", crop_box(), {.saved = true}},
    {"crop-sphere", "filter.crop_sphere", kScene, "x,y,z,r", "keep Gaussians with centres inside this sphere, world frame, m", crop_sphere(), {.saved = true}},
    {"frame", "registration.frame", kScene, "", "captured axis that points up; it becomes world +z",
     choice(kUpAxisNames, [](auto& c) -> auto& { return c.scene.frame; }), {.saved = true}},
    {"mirror", "registration.mirrored", kScene, "", "reverse the x axis of a mirrored capture, before --frame",
     FlagField{[](auto& c) -> auto& { return c.scene.registration.mirrored; }}, {.saved = true}},
    {"scale", "registration.scale", kScene, "m/unit", "metres per captured unit",
     NumberField{[](auto& c) -> auto& { return c.scene.registration.scale; }, Similarity::kScaleMin, Similarity::kScaleMax}, {.saved = true}},
    {"rotate", "registration.rotation", kScene, "qw,qx,qy,qz", "rotation from the captured frame to the world frame",
     rotation([](auto& c) -> auto& { return c.scene.registration.rotation; }), {.saved = true}},
    {"translate", "registration.translation", kScene, "x,y,z", "translation after scale and rotation, m",
     vector([](auto& c) -> auto& { return c.scene.registration.translation; }), {.saved = true}},
    {"no-index-file", "", kScene, "", "neither read nor write the index file SCENE.palpate",
     FlagField{[](auto& c) -> auto& { return c.scene.no_index_file; }}},

    {"model", "model", kForce, "", "force model: proxy (constrained to the surface), field (gradient of a potential) or density (the paper's)",
     choice(kForceModelNames, [](auto& c) -> auto& { return c.force.model; }),
     {.saved = true, .shown_default = "proxy; density with --pipeline paper"}},
    {"materials", "", kForce, "FILE.toml", "proxy: material properties by region of the scene",
     TextField{[](auto& c) -> auto& { return c.force.materials; }}},
    {"stiffness", "stiffness", kForce, "N/m", "proxy and field: contact stiffness",
     NumberField{[](auto& c) -> auto& { return c.force.proxy.stiffness; }, 0.0, kMaterialProperties[kMaterialStiffness].most}, {.saved = true}},
    {"friction", "friction", kForce, "1", "proxy: Coulomb friction coefficient",
     NumberField{[](auto& c) -> auto& { return c.force.proxy.friction; }, 0.0, kMaterialProperties[kMaterialFriction].most}, {.saved = true}},
    {"detail", "detail", kForce, "m", "proxy: kernel width of the surface fit, which smooths smaller detail (default: 0.65 of the shortest semi-axis of each of the tool's parts)",
     OptionalField{.member = [](auto& c) -> auto& { return c.force.proxy.detail; }, .most_parameter = kMostDetail}, {.saved = true}},
    {"k-base", "", kForce, "N", "density: force per colliding Gaussian of opacity 1 (k_base, eq. 9)",
     NumberField{[](auto& c) -> auto& { return c.force.density.k_base; }, 0.0, kMostForce}},
    {"damping", "", kForce, "N.s/m", "density: damping coefficient (D, eq. 10)",
     NumberField{[](auto& c) -> auto& { return c.force.density.damping; }, 0.0, kMostForce}},
    {"f-max", "", kForce, "N", "density: maximum force (F_max, eq. 11)",
     NumberField{[](auto& c) -> auto& { return c.force.density.f_max; }, 0.0, kMostForce}},
    {"tau-direction", "", kForce, "s", "density: time constant of the direction average",
     NumberField{[](auto& c) -> auto& { return c.force.density.tau_direction; }, 0.0, kMostForce}},
    {"tau-opacity", "", kForce, "s", "density: time constant of the opacity average",
     NumberField{[](auto& c) -> auto& { return c.force.density.tau_opacity; }, 0.0, kMostForce}},
    {"tau-velocity", "", kForce, "s", "density: time constant of the velocity filter",
     NumberField{[](auto& c) -> auto& { return c.force.density.tau_velocity; }, 0.0, kMostForce}},

    {"tool", "tool", kTool, "a,b,c|FILE.toml", "semi-axes of an ellipsoid, m; or a file of several ellipsoids (see examples/tools), or its text",
     ToolField{[](auto& c) -> auto& { return c.tool; }}, {.saved = true}},

    {"device", "", kDevice, "", "simulated (impedance device and hand), playback (poses of --trajectory, unaffected by forces), client (of the gateway), giant or giant-mujoco (simulated room-scale admittance device and hand, own or MuJoCo mechanics), or a driver: plugin:PATH.so[:ARGUMENTS] or NAME:ARGUMENTS (ros1:/omni, ros2:/omni)",
     device()},
    {"profile", "", kDevice, "", "device profile: force limits and mechanics", profile()},
    {"trajectory", "", kDevice, "T.csv", "desired tool path of the simulated hand, world frame, back and forth (default: touches the scene at seven places)",
     TextField{[](auto& c) -> auto& { return c.device.trajectory; }}},
    {"client-rate", "", kDevice, "Hz", "minimum pose rate of a client; after three missing poses the force is zero",
     NumberField{[](auto& c) -> auto& { return c.device.client_rate; }, 1.0, 1e4}},
    {"hand", "", kDevice, "m,b,k", "simulated hand: mass, damping and stiffness, in kg, N s/m and N/m", hand()},
    {"workspace-scale", "", kDevice, "1", "world metres per device metre",
     NumberField{[](auto& c) -> auto& { return c.device.map.scale; }, 1e-3, 1e6}},
    {"workspace-rotate", "", kDevice, "qw,qx,qy,qz", "rotation from the device frame to the world frame",
     rotation([](auto& c) -> auto& { return c.device.map.rotation; })},
    {"workspace-offset", "", kDevice, "x,y,z", "position of the device origin, world frame, m",
     vector([](auto& c) -> auto& { return c.device.map.offset; })},

    {"chain", "", kDevice, "FILE.toml|FILE.urdf", "giant: kinematic chain (default: a gantry of 4.7 m x 5.5 m with an arm)",
     TextField{[](auto& c) -> auto& { return c.device.chain; }}},
    {"virtual-mass", "", kDevice, "kg", "giant: virtual mass in free space",
     NumberField{[](auto& c) -> auto& { return c.device.virtual_mass; }, 0.1, 100.0}},
    {"virtual-damping", "", kDevice, "N.s/m", "giant: virtual damping in free space (default: 12, or more if stable contact requires it)",
     OptionalField{.member = [](auto& c) -> auto& { return c.device.virtual_damping; }, .most_parameter = 1e4}},

    {"rate", "", kLoop, "Hz", "rate of the servo loop", NumberField{[](auto& c) -> auto& { return c.loop.rate; }, 10.0, 1e4}},
    {"contacts", "", kLoop, "", "contact search: inline (in the servo loop), worker (lookahead thread), hold (thread with a zero-order hold of the force, as in the paper) or auto (inline or worker)",
     choice(kContactSearchNames, [](auto& c) -> auto& { return c.loop.contacts; })},
    {"worker-delay", "", kLoop, "s", "additional artificial delay of the contact thread, for tests",
     NumberField{[](auto& c) -> auto& { return c.loop.worker_delay; }, 0.0, 1.0}},
    {"cpu", "", kLoop, "", "processor core that the servo loop is pinned to", CountField{[](auto& c) -> auto& { return c.loop.cpu; }, 0, 1023}},

    {"port", "", kGateway, "", "port of the viewer and of rosbridge; 0 = any free port",
     CountField{[](auto& c) -> auto& { return c.gateway.port; }, 0, 65535}, {.shown_default = "9090, or another if that is taken"}},
    {"listen", "", kGateway, "ADDRESS", "local address to listen on; all except loopback require a token",
     TextField{[](auto& c) -> auto& { return c.gateway.address; }}},
    {"token", "", kGateway, "TEXT", "token that clients must present, at least 16 characters (default: generated and printed with --listen)",
     TextField{[](auto& c) -> auto& { return c.gateway.token; }, token_problem}},
    {"tls-cert", "", kGateway, "CERT.pem", "certificate and chain for HTTPS and WSS, required by headsets on the network; needs --tls-key",
     TextField{[](auto& c) -> auto& { return c.gateway.tls_certificate; }}},
    {"tls-key", "", kGateway, "KEY.pem", "private key of the certificate, without a password",
     TextField{[](auto& c) -> auto& { return c.gateway.tls_key; }}},
    {"no-gateway", "", kGateway, "", "run without the gateway", FlagField{[](auto& c) -> auto& { return c.gateway.off; }}},

    {"", "room.scale", kRoom, "1", "world metres per metre of the room",
     NumberField{[](auto& c) -> auto& { return c.room.scale; }, Similarity::kScaleMin, Similarity::kScaleMax}},
    {"", "room.rotation", kRoom, "qw,qx,qy,qz", "rotation from the room frame to the world frame",
     rotation([](auto& c) -> auto& { return c.room.rotation; })},
    {"", "room.translation", kRoom, "x,y,z", "position of the room origin, world frame, m",
     vector([](auto& c) -> auto& { return c.room.translation; })},
  };
}
// clang-format on

/// \name Checks of a value
/// \throws BadValue.
/// @{
void require_finite(double number) {
  if (!std::isfinite(number)) throw BadValue(fmt::format("{} is not a finite number", number));
}
void require_value(const CountField& field, double number) {
  if (!(number >= field.least && number <= field.most) || number != std::floor(number))
    throw BadValue(fmt::format("{} is not a whole number from {} to {}", number, field.least, field.most));
}
void require_value(const NumberField& field, double number) {
  if (!(number >= field.least && number <= field.most))
    throw BadValue(fmt::format("{} is not in {} to {}", number, field.least, field.most));
}
void require_value(const OptionalField& field, double number) {
  require_finite(number);
  if (number > 0.0 && number < field.below) return;
  throw BadValue(field.below == std::numeric_limits<double>::infinity()
                     ? fmt::format("{} is not positive", number)
                     : fmt::format("{} is not between 0 and {}", number, field.below));
}
void require_unit_norm(const Eigen::Quaterniond& q) {
  if (!has_unit_norm(q)) throw BadValue("the quaternion qw,qx,qy,qz must have unit norm; normalize it");
}
void require_part(const ToolPart& part) {
  for (const double a : part.semi_axes) {
    if (!(a >= kMinToolAxis && a <= kMaxToolAxis))
      throw BadValue(fmt::format("semi-axis {} is not in {} to {} m", a, kMinToolAxis, kMaxToolAxis));
  }
  for (const double x : part.pose.position) require_finite(x);
  require_unit_norm(part.pose.orientation);
}
/// @}

/// Parses the value of --tool: semi-axes, the text of a tool file, or its name.
Tool tool_from(const std::string& text) {
  if (text.starts_with("[[")) return parse_tool("--tool", text);
  if (text.ends_with(".toml")) return read_tool(text);
  Tool tool(vector_of(parse_numbers(text, 3, 3)));
  require_part(tool.parts()[0]);
  return tool;
}

/// Implements set_from_text() for each field type.
struct TextSetter {
  LiveConfig& config;
  const std::string& text;

  void operator()(const FlagField& field) const {
    if (text != "true" && text != "false") throw BadValue("must be true or false");
    field.member(config) = text == "true";
  }
  void operator()(const TextField& field) const {
    const std::string problem = field.problem != nullptr ? field.problem(text) : "";
    if (!problem.empty()) throw BadValue(problem);
    field.member(config) = text;
  }
  void operator()(const CountField& field) const {
    const double number = parse_number(text);
    require_value(field, number);
    field.member(config) = static_cast<int>(number);
  }
  void operator()(const NumberField& field) const {
    const double number = parse_number(text);
    require_value(field, number);
    field.member(config) = number;
  }
  void operator()(const OptionalField& field) const {
    const double number = parse_number(text);
    require_value(field, number);
    field.member(config) = number;
  }
  void operator()(const ChoiceField& field) const {
    const auto at = std::find(field.names.begin(), field.names.end(), text);
    const bool other = at == field.names.end() && field.other && field.may_be(text);
    if (field.other) (*field.other)(config) = other ? text : "";
    if (other) return;
    if (at == field.names.end())
      throw BadValue(fmt::format("'{}' is not one of {}", text, fmt::join(field.names, ", ")));
    field.set(config, static_cast<std::size_t>(at - field.names.begin()));
  }
  void operator()(const NumbersField& field) const {
    field.set(config, parse_numbers(text, field.count, field.count));
  }
  void operator()(const ToolField& field) const { field.member(config) = tool_from(text); }
};

/// Implements check_config() for each field type. \throws BadValue.
struct ValueCheck {
  const LiveConfig& config;

  void operator()(const FlagField&) const {}
  void operator()(const TextField& field) const {
    const std::string& text = field.member(config);
    const std::string problem = field.problem == nullptr || text.empty() ? "" : field.problem(text);
    if (!problem.empty()) throw BadValue(problem);
  }
  void operator()(const CountField& field) const {
    const int count = field.member(config);
    if (count != field.member(LiveConfig())) require_value(field, count);
  }
  void operator()(const NumberField& field) const { require_value(field, field.member(config)); }
  void operator()(const OptionalField& field) const {
    const std::optional<double>& number = field.member(config);
    if (number) require_value(field, *number);
  }
  void operator()(const ChoiceField& field) const {
    if (field.chosen(config).empty())
      throw BadValue(fmt::format("is not one of {}", fmt::join(field.names, ", ")));
  }
  void operator()(const NumbersField& field) const {
    const std::vector<double> all = field.get(config);
    if (all.empty()) return;
    for (const double number : all) require_finite(number);
    if (field.unit_norm) require_unit_norm({all[0], all[1], all[2], all[3]});
    LiveConfig other;
    field.set(other, all);
  }
  void operator()(const ToolField& field) const {
    const auto parts = field.member(config).parts();
    if (parts.empty() || parts.size() > kMaxToolParts)
      throw BadValue(fmt::format("has {} ellipsoids, not 1 to {}", parts.size(), kMaxToolParts));
    for (const ToolPart& part : parts) require_part(part);
  }
};

/// Implements default_text() for each field type.
struct DefaultText {
  const LiveConfig& config;

  std::string operator()(const NumberField& field) const { return fmt::format("{}", field.member(config)); }
  std::string operator()(const ChoiceField& field) const { return std::string(field.chosen(config)); }
  std::string operator()(const NumbersField& field) const {
    return field.shows_default ? fmt::format("{}", fmt::join(field.get(config), ",")) : "";
  }
  std::string operator()(const ToolField& field) const {
    return fmt::format("{}", fmt::join(numbers(field.member(config).parts()[0].semi_axes), ","));
  }
  template <class Other>
  std::string operator()(const Other&) const {
    return {};
  }
};

}  // namespace

std::string_view title(ConfigGroup group) {
  switch (group) {
    case kScene: return "Scene";
    case kTool: return "Tool";
    case kForce: return "Force";
    case kDevice: return "Device";
    case kLoop: return "Loop";
    case kGateway: return "Gateway";
    case kRoom: return "Room";
  }
  return {};
}

std::span<const ConfigField> config_fields() {
  static const std::vector<ConfigField> fields = make_fields();
  return fields;
}

const ConfigField& config_field(std::string_view name) {
  const auto fields = config_fields();
  const auto at = std::find_if(fields.begin(), fields.end(),
                               [&](const ConfigField& field) { return !name.empty() && field.name == name; });
  if (at == fields.end()) throw Error("'{}' is not a setting of a live system", printable(name));
  return *at;
}

void set_from_text(const ConfigField& field, LiveConfig& config, const std::string& text) {
  std::visit(TextSetter{config, text}, field.type);
}

void check_config(const LiveConfig& config) {
  std::string_view name;
  try {
    for (const ConfigField& field : config_fields()) {
      name = field.name.empty() ? field.parameter : field.name;
      std::visit(ValueCheck{config}, field.type);
    }
    name = "the tool of the workspace map";  // which is no field
    require_unit_norm(config.device.map.tool);
  } catch (const BadValue& error) {
    throw Error("LiveConfig: {}: {}; correct it", name, error.what());
  }
}

std::string default_text(const ConfigField& field, const LiveConfig& config) {
  if (!field.traits.shown_default.empty()) return std::string(field.traits.shown_default);
  return std::visit(DefaultText{config}, field.type);
}

}  // namespace palpate
