/// \file
/// Who may ask the server for anything.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

/// What a request says of itself. Empty: it does not.
struct RequestHead {
  std::string_view host, origin, authorization, cookie;
  std::string_view target;  ///< path and query
};

/// Decides by what a request says.
class Access {
 public:
  /// \param port that is listened on. \param token empty: none is wanted
  Access(std::string address, unsigned port, std::string token)
      : address_(std::move(address)), port_(port), token_(std::move(token)) {}

  struct Refused {
    int status;  ///< of HTTP: 401 where a token would help
    std::string why;
  };
  /// Nothing if it is not refused.
  std::optional<Refused> refusal(const RequestHead& head) const;

  const std::string& token() const { return token_; }

 private:
  bool is_own_host(std::string_view host) const;

  std::string address_;
  unsigned port_;
  std::string token_;
};

/// The path of a target without its query, percent-decoded; nothing if that is not well-formed, not absolute,
/// or climbs with "..".
std::optional<std::string> path_of(std::string_view target);

/// The value of `name` in the query of a target; empty if it has none.
std::string query_value(std::string_view target, std::string_view name);

/// A part of something that is `size` long.
struct ByteRange {
  std::uint64_t first = 0, count = 0;
};
/// What the value of a Range header asks for. RFC 9110, one range of bytes; several, or something else, are
/// as none.
struct RangeRequest {
  enum class Kind { kNone, kPart, kUnsatisfiable } kind = Kind::kNone;
  ByteRange range;
};
RangeRequest parse_range(std::string_view value, std::uint64_t size);

}  // namespace palpate
