/// \file
/// Configuration of a live system as a TOML file: the keys of `palpate run --config`.
#pragma once

#include <cstdint>
#include <string>

#include <palpate/live/live_config.h>

namespace palpate {

/// Which fields a file has.
enum class TomlFields : std::uint8_t {
  kSaved,  ///< the settings that a person works out and keeps: scene, tool and force
  kAll,    ///< all that have a name, SceneConfig::path as `scene`, too
};

/// The text of a file that is read as `config`. Numbers read back exactly. Booleans that are false, and what
/// is not set, are left out.
std::string to_toml(const LiveConfig& config, TomlFields fields);

/// Reads such a file over `defaults`. \throws Error with file and line if it is not TOML, has a key that is
/// no field, a value that the field cannot take, or two fields that exclude each other.
LiveConfig read_live_config(const std::string& path, LiveConfig defaults = {});

}  // namespace palpate
