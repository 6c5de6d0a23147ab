/// \file
/// Access control of the web server.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace palpate {

/// Returns 128 random bits from the system, as 32 hexadecimal digits.
std::string random_text();

/// Returns why `token` is too weak or cannot be part of a URL; empty if it is valid.
std::string token_problem(std::string_view token);
inline constexpr std::size_t kLeastToken = 16, kMostToken = 256;  ///< characters

/// Returns the key for GuessLimit of an address: the 64-bit network of an IPv6 address, since one host may
/// use all of its addresses. \param address as text, with or without a zone
std::string guesser_at(const std::string& address);

/// Rate limit of wrong tokens, per address and in total. Each attempt is forgotten after a while, by elapsed
/// time.
class GuessLimit {
 public:
  static constexpr double kOfOne = 5.0, kOfAll = 50.0;        ///< burst, of one address and of all
  static constexpr double kOneAgain = 10.0, kAllAgain = 1.0;  ///< time per further attempt. Unit: [s].

  /// Returns whether an attempt is permitted. \param now Unit: [s]. Monotonic.
  bool permits(std::string_view address, double now) const;
  void count_wrong(std::string_view address, double now);
  /// Marks an address that presented the token: from now on only its own wrong tokens count against it.
  void count_right(std::string_view address) { trusted_.emplace(address); }

 private:
  /// Leaky bucket that drains by one in `again` seconds.
  struct Bucket {
    double filled = 0.0, at = 0.0;  ///< level at time `at`. Unit of `at`: [s].
    double level(double now, double again) const;
  };
  Bucket all_;
  std::map<std::string, Bucket, std::less<>> of_;  ///< by address; non-empty buckets only
  std::set<std::string, std::less<>> trusted_;
};

/// Header fields and origin of a request; empty if absent.
struct RequestHead {
  std::string_view host, origin, authorization, cookie;
  std::string_view target;        ///< path and query
  std::string_view address = {};  ///< of the client, for GuessLimit
  bool logged_in = false;         ///< an earlier request of this connection was accepted
};

/// Decides whether a request is accepted, from its header. Used by one thread.
class Access {
 public:
  /// \param port of the server. \param token empty: none is required. \param session secret cookie value of
  /// clients that have presented the token; must be unguessable
  Access(std::string address, unsigned port, std::string token, std::string session)
      : address_(std::move(address)), port_(port), token_(std::move(token)), session_(std::move(session)) {}

  struct Refused {
    int status;  ///< HTTP status: 401 if a token is required, 429 if the client must retry later
    std::string why;
    std::string notice = {};  ///< printable line for the person at the terminal; empty: none
  };
  /// Number of origins, each named once, that notices name: any web page can cause one.
  static constexpr std::size_t kMostNotices = 8;
  /// Returns why a request is refused; nothing if it is accepted. \param now Unit: [s].
  std::optional<Refused> refusal(const RequestHead& head, double now);
  /// Returns whether an accepted request carries the token in its URL, so that it should get the cookie.
  bool has_token_in_target(const RequestHead& head) const;
  /// Returns the cookie as NAME=VALUE. The name differs between servers of one host, since a browser sends
  /// cookies to all of them.
  std::string cookie() const;

  const std::string& token() const { return token_; }

 private:
  bool is_own_host(std::string_view host) const;
  std::string cookie_name() const;
  std::optional<Refused> refusal_of_token(const RequestHead& head, double now);
  std::string notice_of(const std::string& origin);

  std::string address_;
  unsigned port_;
  std::string token_, session_;
  GuessLimit guesses_;
  std::set<std::string, std::less<>> noticed_;  ///< refused origins that a notice has named
};

/// Returns `target` with parameter `name` removed from its query.
std::string without_query_value(std::string_view target, std::string_view name);

/// Returns the path of a target without its query, percent-decoded; nothing if it is malformed, not absolute,
/// or contains "..".
std::optional<std::string> path_of(std::string_view target);

/// Returns the value of `name` in the query of a target; empty if absent.
std::string query_value(std::string_view target, std::string_view name);

/// A range of bytes.
struct ByteRange {
  std::uint64_t first = 0, count = 0;
};
/// Parsed value of a Range header (RFC 9110): one range of bytes; multiple ranges and other units are treated
/// as none.
struct RangeRequest {
  enum class Kind { kNone, kPart, kUnsatisfiable } kind = Kind::kNone;
  ByteRange range;
};
RangeRequest parse_range(std::string_view value, std::uint64_t size);

}  // namespace palpate
