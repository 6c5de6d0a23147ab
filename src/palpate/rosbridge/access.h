/// \file
/// Who may ask the server for anything.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace palpate {

/// 128 bits from the system, as 32 hexadecimal digits.
std::string random_text();

/// Why `token` is too weak to be one, or cannot be part of an address; empty if it is good.
std::string token_problem(std::string_view token);
inline constexpr std::size_t kLeastToken = 16, kMostToken = 256;  ///< characters

/// Whose guesses come from an address, for GuessLimit: who has one address of IPv6 has all of its network of
/// 64 bits. \param address as text, with a zone or without
std::string guesser_at(const std::string& address);

/// How many wrong tokens may still come. Each is forgotten after a while, by elapsed time.
class GuessLimit {
 public:
  static constexpr double kOfOne = 5.0, kOfAll = 50.0;        ///< at once, of one address and of all
  static constexpr double kOneAgain = 10.0, kAllAgain = 1.0;  ///< until one more may come. Unit: [s].

  /// \param now Unit: [s]. Never falls.
  bool permits(std::string_view address, double now) const;
  void count_wrong(std::string_view address, double now);
  /// Has had the token: only what comes from there itself counts against it from now on.
  void count_right(std::string_view address) { trusted_.emplace(address); }

 private:
  /// Empties by one in `again` seconds.
  struct Bucket {
    double filled = 0.0, at = 0.0;  ///< then. Unit of `at`: [s].
    double level(double now, double again) const;
  };
  Bucket all_;
  std::map<std::string, Bucket, std::less<>> of_;  ///< by address; only those that are not empty
  std::set<std::string, std::less<>> trusted_;
};

/// What a request says of itself, and where it comes from. Empty: it does not.
struct RequestHead {
  std::string_view host, origin, authorization, cookie;
  std::string_view target;        ///< path and query
  std::string_view address = {};  ///< of who asks, for GuessLimit
  bool logged_in = false;         ///< an earlier request of this connection was not refused
};

/// Decides by what a request says. Used by one thread.
class Access {
 public:
  /// \param port that is listened on. \param token empty: none is wanted. \param session what the cookie of
  /// who has brought the token says; no one may guess it
  Access(std::string address, unsigned port, std::string token, std::string session)
      : address_(std::move(address)), port_(port), token_(std::move(token)), session_(std::move(session)) {}

  struct Refused {
    int status;  ///< of HTTP: 401 where a token would help, 429 where it would later
    std::string why;
  };
  /// Nothing if it is not refused. \param now Unit: [s].
  std::optional<Refused> refusal(const RequestHead& head, double now);
  /// Of a request that is not refused: it has brought the token in its address, and had better get the
  /// cookie.
  bool has_token_in_target(const RequestHead& head) const;
  /// NAME=VALUE. The name tells servers of one host apart, to all of which a browser sends it.
  std::string cookie() const;

  const std::string& token() const { return token_; }

 private:
  bool is_own_host(std::string_view host) const;
  std::string cookie_name() const;
  std::optional<Refused> refusal_of_token(const RequestHead& head, double now);

  std::string address_;
  unsigned port_;
  std::string token_, session_;
  GuessLimit guesses_;
};

/// `target` without what its query says of `name`.
std::string without_query_value(std::string_view target, std::string_view name);

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
