/// \file
/// Devices from shared libraries.
#pragma once

#include <memory>
#include <string>

#include <palpate/servo/haptic_device.h>

namespace palpate {

/// A device of the plug-in at `path` (palpate/device/device_plugin.h), not open yet. The library stays loaded
/// until the process ends. \param arguments for the plug-in; the kernel's loader must find what it links.
/// \throws Error, one line with `path`, if there is no such file, it is no plug-in of this version, lacks a
/// function, or cannot make the device.
std::unique_ptr<HapticDevice> make_plugin_device(const std::string& path, const std::string& arguments);

/// A device by the text after --device:
///
///     plugin:PATH.so[:ARGUMENTS]   the plug-in at PATH
///     NAME:ARGUMENTS               palpate_device_NAME.so beside the program, or in ../lib/palpate from
///     there
///
/// \throws Error likewise, or if the text has neither form.
std::unique_ptr<HapticDevice> make_plugin_device(const std::string& text);

/// True for text of one of these forms.
bool names_plugin(const std::string& text);

}  // namespace palpate
