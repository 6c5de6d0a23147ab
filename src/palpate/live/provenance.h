/// \file
/// Provenance of a result: program, scene, settings, device and machine.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/config_fields.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/live_config.h>

namespace palpate {

/// Information needed to reproduce a result.
struct Provenance {
  std::vector<SettingText> made;      ///< version, command, names, checksums, machine
  std::vector<SettingText> settings;  ///< long options of the command
};

/// The scene that a result was made with.
struct SceneOrigin {
  std::string name;      ///< file name without its folder, or display name; empty: none
  std::string checksum;  ///< see file_checksum(); empty if it is not a file
};

/// Returns the origin of SceneConfig::path, without reading the file if the index beside it has the checksum;
/// with an empty path, of the built-in scene. \throws Error.
SceneOrigin scene_origin(const SceneConfig& scene);

/// Returns the provenance of a command that uses the fields of `groups`. \throws Error if the materials file
/// cannot be read.
Provenance provenance(std::string_view command, const SceneOrigin& scene, const LiveConfig& config,
                      std::initializer_list<ConfigGroup> groups);

/// Changes or adds a setting. \param value as TOML
void set(Provenance& provenance, std::string_view name, const std::string& value);
/// The same for a plain text value: quoted unless TOML would read it as a number, true or false.
void set_text(Provenance& provenance, std::string_view name, const std::string& text);

/// Returns the TOML tables [made] and [settings], the header of a run's file (write_run()) and of other
/// tables.
std::string to_toml(const Provenance& provenance);

/// Returns the checksum of a file's content: "xxh3-16MiB:0123456789abcdef", the XXH3 over the XXH3 of every
/// 16 MiB. \throws Error.
std::string file_checksum(const std::string& path);

}  // namespace palpate
