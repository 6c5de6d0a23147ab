#include "declare.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <palpate/live/config_fields.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate::cli {
namespace {

/// Makes an option a list: values separated by commas, or the option repeated. An argument after the list is
/// not part of it.
CLI::Option* listed(CLI::Option* option) {
  return option->delimiter(',')->allow_extra_args(false)->capture_default_str();
}

/// Returns whether `name` is a field of a LiveConfig.
bool is_field(const std::string& name) {
  const auto fields = config_fields();
  return name == "scene" || std::any_of(fields.begin(), fields.end(),
                                        [&](const ConfigField& field) { return field.name == name; });
}

/// Returns whether an option only affects where results go or how fast they are computed.
bool is_no_setting(const std::string& name) {
  constexpr std::array<std::string_view, 13> kThose{"help",      "quiet",   "json", "config", "from",
                                                    "out",       "record",  "csv",  "html",   "svg",
                                                    "histogram", "threads", "worst"};
  return std::find(kThose.begin(), kThose.end(), name) != kThose.end();
}

/// Removes the brackets that CLI11 puts around the default of a list.
std::string without_brackets(const std::string& text) {
  return text.starts_with('[') && text.ends_with(']') ? text.substr(1, text.size() - 2) : text;
}

}  // namespace

DeclaredOption& DeclaredOption::required() {
  option_->required();
  return *this;
}

DeclaredOption& DeclaredOption::in_group(const std::string& group) {
  option_->group(group);
  return *this;
}

DeclaredOption& DeclaredOption::shows_default(const std::string& text) {
  option_->default_str(text);
  return *this;
}

DeclaredOption& DeclaredOption::excludes(const DeclaredOption& other) {
  option_->excludes(other.option_);
  return *this;
}

CLI::App& add_command(CLI::App& parent, const std::string& name, const std::string& description) {
  return *parent.add_subcommand(name, description);
}

CLI::App& add_hidden_command(CLI::App& parent, const std::string& name, const std::string& description) {
  return *parent.add_subcommand(name, description)->group("");
}

DeclaredOption add_flag(CLI::App& app, const std::string& name, bool& value, const std::string& description) {
  return DeclaredOption(app.add_flag(name, value, description));
}

DeclaredOption add_text(CLI::App& app, const std::string& name, std::string& value, const std::string& type,
                        const std::string& description) {
  CLI::Option* option = app.add_option(name, value, description);
  if (!type.empty()) option->type_name(type);
  return DeclaredOption(option);
}

DeclaredOption add_choice(CLI::App& app, const std::string& name, std::string& value,
                          const std::vector<std::string>& choices, const std::string& description) {
  return DeclaredOption(
      app.add_option(name, value, description)->check(CLI::IsMember(choices))->capture_default_str());
}

DeclaredOption add_choice(CLI::App& app, const std::string& name, const std::vector<std::string>& choices,
                          const std::string& description,
                          const std::function<void(const std::string&)>& set) {
  return DeclaredOption(
      app.add_option_function<std::string>(name, set, description)->check(CLI::IsMember(choices)));
}

DeclaredOption add_choices(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                           const std::vector<std::string>& choices, const std::string& description) {
  return DeclaredOption(listed(app.add_option(name, values, description))->check(CLI::IsMember(choices)));
}

DeclaredOption add_texts(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                         const std::string& type, const std::string& description) {
  return DeclaredOption(listed(app.add_option(name, values, description))->type_name(type));
}

DeclaredOption add_files(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                         const std::string& description) {
  return DeclaredOption(app.add_option(name, values, description)->type_name(""));
}

DeclaredOption add_count(CLI::App& app, const std::string& name, int& value, int low, int high,
                         const std::string& description) {
  CLI::Option* option = app.add_option(name, value, description)->check(CLI::Range(low, high));
  if (value >= low && value <= high) option->capture_default_str();
  return DeclaredOption(option);
}

DeclaredOption add_number(CLI::App& app, const std::string& name, double& value, double low, double high,
                          const std::string& unit, const std::string& description) {
  const auto set = [&value, low, high](const std::string& text) {
    const double number = parse_number(text);
    if (!(number >= low && number <= high)) {
      throw BadValue(fmt::format("{} is not in {} to {}", text, low, high));
    }
    value = number;
  };
  return add_parsed(app, name, unit, description, set).shows_default(fmt::format("{}", value));
}

DeclaredOption add_numbers(CLI::App& app, const std::string& name, std::vector<double>& values, double low,
                           double high, const std::string& description) {
  return DeclaredOption(listed(app.add_option(name, values, description))->check(CLI::Range(low, high)));
}

DeclaredOption add_seed(CLI::App& app, std::uint64_t& seed, const std::string& description) {
  const auto set = [&seed](const std::string& text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) {
      throw BadValue(fmt::format("'{}' is not a whole number from 0 to 2^64-1", text));
    }
    seed = value;
  };
  return add_parsed(app, "--seed", "n", description, set).shows_default(fmt::format("{}", seed));
}

DeclaredOption add_vector3(CLI::App& app, const std::string& name, Eigen::Vector3d& value,
                           const std::string& unit, const std::string& description) {
  const auto set = [&value](const std::string& text) {
    const auto v = parse_numbers(text, 3, 3);
    value = {v[0], v[1], v[2]};
  };
  return add_parsed(app, name, "x,y,z", description + ", " + unit, set)
      .shows_default(fmt::format("{},{},{}", value.x(), value.y(), value.z()));
}

DeclaredOption add_parsed(CLI::App& app, const std::string& name, const std::string& type,
                          const std::string& description,
                          const std::function<void(const std::string&)>& set) {
  const auto callback = [name, set](const CLI::results_t& results) {
    try {
      set(results.front());
    } catch (const BadValue& error) {
      throw CLI::ValidationError(name, error.what());
    }
    return true;
  };
  CLI::Option* option = app.add_option(name, callback, description);
  return DeclaredOption(option->type_name(type)->type_size(1)->expected(1));
}

Pose parse_pose(const std::string& text) {
  const auto v = parse_numbers(text, 3, 7);
  if (v.size() != 3 && v.size() != 7) {
    throw BadValue(fmt::format("'{}' has {} numbers; 3 or 7 are needed", text, v.size()));
  }
  Pose pose;
  pose.position = {v[0], v[1], v[2]};
  if (pose.position.cwiseAbs().maxCoeff() > kMaxExtent) {
    throw BadValue(fmt::format("'{}' is more than {} m from the origin", text, kMaxExtent));
  }
  if (v.size() == 7) pose.orientation = parse_quaternion(v.data() + 3);
  return pose;
}

void need_unless(CLI::App& app, const std::vector<std::string>& options, const std::string& instead) {
  app.parse_complete_callback([&app, options, instead] {
    if (is_given(app, instead)) return;
    for (const std::string& option : options)
      if (!is_given(app, option)) throw CLI::RequiredError(fmt::format("{} or {}", option, instead));
  });
}

void need(CLI::App& app, const std::vector<std::string>& options, const std::string& needed) {
  for (const std::string& option : options) app.get_option(option)->needs(app.get_option(needed));
}

void exclude(CLI::App& app, const std::vector<std::string>& options, const std::string& other) {
  CLI::Option* const excluded = app.get_option(other);
  for (const std::string& option : options) {
    app.get_option(option)->excludes(excluded);
    // --help of `other` would list all of them.
    excluded->remove_excludes(app.get_option(option));
  }
}

std::string command_name(const CLI::App& app) { return app.get_name(); }

std::vector<std::pair<std::string, std::string>> other_options(const CLI::App& app) {
  std::vector<std::pair<std::string, std::string>> all;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    if (is_field(name) || is_no_setting(name)) continue;
    const std::string text = option->count() > 0 ? fmt::format("{}", fmt::join(option->results(), ","))
                                                 : option->get_default_str();
    if (!text.empty()) all.emplace_back(name, without_brackets(text));
  }
  return all;
}

bool is_given(const CLI::App& app, const std::string& option) { return app.count(option) > 0; }

}  // namespace palpate::cli
