/// \file
/// How a result was made: program, scene, settings, device and machine.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/config_fields.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/live_config.h>

namespace palpate {

/// What is told of a result, for whoever wants to know, or to make it again.
struct Provenance {
  std::vector<SettingText> made;      ///< version, command, names, checksums, machine
  std::vector<SettingText> settings;  ///< long options of the command
};

/// The scene that a result was made with.
struct SceneOrigin {
  std::string name;      ///< of the file, without its folder, or for people; empty: none
  std::string checksum;  ///< see file_checksum(); empty if it is no file
};

/// Of SceneConfig::path, whose file is not read where the index beside it knows; without, of the built-in
/// scene. \throws Error.
SceneOrigin scene_origin(const SceneConfig& scene);

/// Of a command that has the fields of these groups. \throws Error if the file of the materials cannot be
/// read.
Provenance provenance(std::string_view command, const SceneOrigin& scene, const LiveConfig& config,
                      std::initializer_list<ConfigGroup> groups);

/// Changes a setting, or adds it. \param value as TOML
void set(Provenance& provenance, std::string_view name, const std::string& value);
/// The same of a value in any words: quoted where TOML would not take it for a number, true or false.
void set_text(Provenance& provenance, std::string_view name, const std::string& text);

/// TOML: the tables [made] and [settings]. The head of a run's file (write_run()) and of other tables.
std::string to_toml(const Provenance& provenance);

/// The name that files have for what is in a file: "xxh3-16MiB:0123456789abcdef", XXH3 over the XXH3 of every
/// 16 MiB. \throws Error.
std::string file_checksum(const std::string& path);

}  // namespace palpate
