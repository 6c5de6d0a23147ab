/// \file
/// Loader of device plug-ins.
#pragma once

#include <memory>
#include <string>

#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Creates a device from the plug-in at `path` (palpate/device/device_plugin.h), not open yet. The library
/// stays loaded until the process ends; the dynamic loader must find the libraries it links. \param arguments
/// for the plug-in. \throws Error, one line with `path`, if there is no such file, it is no plug-in of this
/// version, lacks a function, or cannot create the device.
std::unique_ptr<HapticDevice> make_plugin_device(const std::string& path, const std::string& arguments);

/// Creates a device from the argument of --device:
///
///     plugin:PATH.so[:ARGUMENTS]   the plug-in at PATH
///     NAME:ARGUMENTS               palpate_device_NAME.so beside the program, or in ../lib/palpate from
///     there
///
/// \throws Error likewise, or if the text has neither form.
std::unique_ptr<HapticDevice> make_plugin_device(const std::string& text);

/// Returns true if the text has one of these forms.
bool names_plugin(const std::string& text);

}  // namespace palpate
