#include "live_parameters.h"

#include <algorithm>
#include <functional>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/base/error.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/scene/material_properties.h>

namespace palpate::cli {
namespace {

Value numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Value numbers(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

/// Of the axes of the captured frame and the point between them, column by column.
Value matrix_of(const Similarity& s) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = s.scale * s.orthogonal();
  m.topRightCorner<3, 1>() = s.translation;
  return std::vector<double>(m.data(), m.data() + m.size());
}

double number_in(const Value& value, const std::string& name, double low, double high) {
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!(number >= low && number <= high))
    throw Refusal(fmt::format("'{}' must be a number from {} to {}", name, low, high));
  return number;
}

std::string text_of(const Value& value, const std::string& name) {
  if (!value.is_string()) throw Refusal(fmt::format("'{}' must be text", name));
  return value.get<std::string>();
}

template <std::size_t N>
std::array<double, N> numbers_of(const Value& value, const std::string& name, double most) {
  std::array<double, N> result{};
  if (!value.is_array() || value.size() != N) throw Refusal(fmt::format("'{}' must be {} numbers", name, N));
  for (std::size_t i = 0; i < N; ++i) result[i] = number_in(value[i], name, -most, most);
  return result;
}

constexpr double kFarthest = 1e9;  // m

Eigen::Vector3d vector_of(const Value& value, const std::string& name) {
  const auto v = numbers_of<3>(value, name, kFarthest);
  return {v[0], v[1], v[2]};
}

Eigen::Quaterniond quaternion_of(const Value& value, const std::string& name) {
  const auto q = numbers_of<4>(value, name, 1e6);
  try {
    return parse_quaternion(q.data());
  } catch (const BadValue& error) {
    throw Refusal(fmt::format("'{}': {}", name, error.what()));
  }
}

ToolPart part_of(const Value& value) {
  if (!value.is_object()) throw Refusal("'tool' must be ellipsoids, each with 'semi_axes'");
  ToolPart part;
  part.name = text_field(value, "name");
  const auto a = numbers_of<3>(field(value, "semi_axes"), "semi_axes", kMaxToolAxis);
  if (*std::min_element(a.begin(), a.end()) < kMinToolAxis)
    throw Refusal(fmt::format("'semi_axes' must be {} m or more", kMinToolAxis));
  part.semi_axes = {a[0], a[1], a[2]};
  if (value.contains("position")) part.pose.position = vector_of(value["position"], "position");
  if (value.contains("orientation"))
    part.pose.orientation = quaternion_of(value["orientation"], "orientation");
  return part;
}

Tool tool_of(const Value& value) {
  if (!value.is_array() || value.empty() || value.size() > kMaxToolParts)
    throw Refusal(fmt::format("'tool' must be 1 to {} ellipsoids", kMaxToolParts));
  std::vector<ToolPart> parts;
  for (const Value& part : value) parts.push_back(part_of(part));
  return Tool(std::move(parts));
}

using Setters = std::map<std::string, std::function<void(const Value&, const std::string& name)>>;

/// Calls for every name in `wanted` what `setters` has for it.
void set_all(const Value& wanted, const std::string& where, const Setters& setters) {
  if (!wanted.is_object()) throw Refusal(fmt::format("'{}' must be an object", where));
  for (const auto& [name, value] : wanted.items()) {
    const auto setter = setters.find(name);
    if (setter == setters.end()) {
      std::vector<std::string> known;
      for (const auto& [one, ignored] : setters) known.push_back(one);
      throw Refusal(fmt::format("{} has no '{}'; it has {}", where, printable(name.substr(0, 40)),
                                fmt::join(known, ", ")));
    }
    setter->second(value, name);
  }
}

void change_place(Similarity& place, const Value& wanted, const std::string& where, Setters setters) {
  setters["scale"] = [&](const Value& v, const std::string& n) { place.scale = number_in(v, n, 1e-9, 1e9); };
  setters["rotation"] = [&](const Value& v, const std::string& n) { place.rotation = quaternion_of(v, n); };
  setters["translation"] = [&](const Value& v, const std::string& n) { place.translation = vector_of(v, n); };
  set_all(wanted, where, setters);
}

void change_registration(SceneOptions& scene, const Value& wanted) {
  const auto frame = [&](const Value& value, const std::string& name) {
    const std::string asked = text_of(value, name);
    const std::vector<std::string> known = frame_names();
    if (std::find(known.begin(), known.end(), asked) == known.end())
      throw Refusal(fmt::format("'frame' must be one of {}", fmt::join(known, ", ")));
    scene.frame = asked;
  };
  const auto mirrored = [&](const Value& value, const std::string& name) {
    if (!value.is_boolean()) throw Refusal(fmt::format("'{}' must be true or false", name));
    scene.registration.mirrored = value.get<bool>();
  };
  change_place(scene.registration, wanted, "registration", {{"frame", frame}, {"mirrored", mirrored}});
}

void change_filter(SceneFilter& filter, const Value& wanted) {
  set_all(wanted, "filter",
          {{"opacity_min",
            [&](const Value& v, const std::string& n) { filter.opacity_min = number_in(v, n, 0.0, 1.0); }},
           {"sigma", [&](const Value& v, const std::string& n) {
              filter.sigma = number_in(v, n, 1e-6, SceneFilter::kSigmaMax);
              filter.iso.reset();
            }}});
}

void set_detail(ProxyParameters& proxy, double detail) {
  proxy.detail.reset();
  if (detail > 0.0) proxy.detail = detail;
}

}  // namespace

Value settings_json(const LiveSettings& s) {
  const ProxyParameters& proxy = s.force.proxy;
  Value tool = Value::array();
  for (const ToolPart& part : s.tool.parts())
    tool.push_back({{"name", part.name},
                    {"semi_axes", numbers(part.semi_axes)},
                    {"position", numbers(part.pose.position)},
                    {"orientation", numbers(part.pose.orientation)}});
  return {{"registration",
           {{"frame", s.scene.frame},
            {"mirrored", s.scene.registration.mirrored},
            {"scale", s.scene.registration.scale},
            {"rotation", numbers(s.scene.registration.rotation)},
            {"translation", numbers(s.scene.registration.translation)},
            {"matrix", matrix_of(s.scene.world_from_scene())}}},
          {"filter",
           {{"opacity_min", s.scene.filter.opacity_min},
            {"sigma", s.scene.filter.sigma},
            {"iso", s.scene.filter.iso.value_or(0.0)}}},
          {"model", kModels[s.model]},
          {"stiffness", proxy.stiffness},
          {"friction", proxy.friction},
          {"detail", proxy.detail.value_or(0.0)},
          {"tool", std::move(tool)},
          {"room",
           {{"scale", s.room.scale},
            {"rotation", numbers(s.room.rotation)},
            {"translation", numbers(s.room.translation)}}}};
}

void change_settings(LiveSettings& settings, const Value& wanted) {
  ProxyParameters& proxy = settings.force.proxy;
  const auto within = [](double& target, double most) {
    return [&target, most](const Value& v, const std::string& n) { target = number_in(v, n, 0.0, most); };
  };
  const auto model = [&](const Value& value, const std::string& name) {
    const auto at = std::find(kModels.begin(), kModels.end(), text_of(value, name));
    if (at == kModels.end())
      throw Refusal(fmt::format("'model' must be one of {}", fmt::join(kModels, ", ")));
    settings.model = static_cast<std::size_t>(at - kModels.begin());
  };
  set_all(
      wanted, "parameters",
      {{"model", model},
       {"stiffness", within(proxy.stiffness, kMaterialProperties[kMaterialStiffness].most)},
       {"friction", within(proxy.friction, kMaterialProperties[kMaterialFriction].most)},
       {"detail",
        [&](const Value& v, const std::string& n) { set_detail(proxy, number_in(v, n, 0.0, 10.0)); }},
       {"tool", [&](const Value& v, const std::string&) { settings.tool = tool_of(v); }},
       {"filter", [&](const Value& v, const std::string&) { change_filter(settings.scene.filter, v); }},
       {"registration", [&](const Value& v, const std::string&) { change_registration(settings.scene, v); }},
       {"room", [&](const Value& v, const std::string& n) { change_place(settings.room, v, n, {}); }}});
}

std::string settings_toml(const LiveSettings& s) {
  const SceneFilter& filter = s.scene.filter;
  const Similarity& place = s.scene.registration;
  const ProxyParameters& proxy = s.force.proxy;
  const auto& q = place.rotation;
  std::string text = "# For palpate --config.\n";
  text += fmt::format("opacity-min = {}\n", filter.opacity_min);
  text += filter.iso ? fmt::format("iso = {}\n", *filter.iso) : fmt::format("sigma = {}\n", filter.sigma);
  if (filter.max_scale) text += fmt::format("max-scale = {}\n", *filter.max_scale);
  if (filter.crop_box) {
    const Eigen::Vector3d &a = filter.crop_box->min(), &b = filter.crop_box->max();
    text += fmt::format("crop-box = [{}, {}, {}, {}, {}, {}]\n", a[0], a[1], a[2], b[0], b[1], b[2]);
  }
  if (filter.crop_sphere) {
    const Eigen::Vector3d& c = filter.crop_sphere->center;
    text += fmt::format("crop-sphere = [{}, {}, {}, {}]\n", c[0], c[1], c[2], filter.crop_sphere->radius);
  }
  text += fmt::format("frame = \"{}\"\nscale = {}\nrotate = [{}, {}, {}, {}]\ntranslate = [{}, {}, {}]\n",
                      s.scene.frame, place.scale, q.w(), q.x(), q.y(), q.z(), place.translation.x(),
                      place.translation.y(), place.translation.z());
  if (place.mirrored) text += "mirror = true\n";
  text += fmt::format("model = \"{}\"\nstiffness = {}\nfriction = {}\n", kModels[s.model], proxy.stiffness,
                      proxy.friction);
  if (proxy.detail) text += fmt::format("detail = {}\n", *proxy.detail);
  const ToolPart& part = s.tool.parts()[0];
  const bool one = s.tool.parts().size() == 1 && part.pose.position.isZero(0.0) &&
                   part.pose.orientation.isApprox(Eigen::Quaterniond::Identity());
  const Eigen::Vector3d& a = part.semi_axes;
  // A literal string, whose first line break is no part of it.
  text += one ? fmt::format("tool = [{}, {}, {}]\n", a.x(), a.y(), a.z())
              : fmt::format("tool = '''\n{}'''\n", tool_text(s.tool));
  return text;
}

}  // namespace palpate::cli
