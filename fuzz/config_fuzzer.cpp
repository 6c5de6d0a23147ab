// Configuration files: read_config() either throws Error or returns entries with line numbers.
#include <cstddef>
#include <cstdint>

#include <palpate/base/error.h>
#include <palpate/live/config_toml.h>

#include "input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static palpate::fuzz::InputFile file;
  try {
    for (const auto& entry : palpate::read_config(file.hold(data, size, "config.toml")))
      palpate::fuzz::require(entry.line > 0);
  } catch (const palpate::Error&) {
  }
  return 0;
}
