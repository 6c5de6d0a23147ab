/// \file
/// JSON as CBOR, as clients of rosbridge send it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/rosbridge/message.h>

namespace palpate::test {

inline std::string cbor_of(const Json& value) {
  const std::vector<std::uint8_t> encoded = Json::to_cbor(value);
  return {encoded.begin(), encoded.end()};
}

}  // namespace palpate::test
