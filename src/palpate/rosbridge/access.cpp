#include <palpate/rosbridge/access.h>

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <random>

#include <fmt/format.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

/// Compares in constant time, so that the time reveals only the length.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size() || b.empty()) return false;
  unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

/// Returns whether `name` is an address or "localhost", which no remote server can claim as its name.
bool is_address(std::string_view name) {
  if (name == "localhost" || name.starts_with('[')) return true;
  return !name.empty() && std::all_of(name.begin(), name.end(),
                                      [](unsigned char c) { return std::isdigit(c) != 0 || c == '.'; });
}

/// Returns the value of `name` in a Cookie header such as "a=1; b=2"; empty if absent.
std::string_view cookie_value(std::string_view cookies, std::string_view name) {
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    std::string_view one = cookies.substr(0, end);
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
    while (one.starts_with(' ')) one.remove_prefix(1);
    if (one.starts_with(name) && one.substr(name.size()).starts_with('=')) return one.substr(name.size() + 1);
  }
  return {};
}

int digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::optional<std::string> decoded(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      result += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? digit(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? digit(text[i + 2]) : -1;
    if (high < 0 || low < 0) return std::nullopt;
    result += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return result;
}

std::optional<std::uint64_t> number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

/// Without a token, names other than "localhost" are refused: any web page can let its own name resolve to
/// this machine (DNS rebinding), but cannot make a browser send an address as Host. With a token, a name
/// alone grants no access.
bool Access::is_own_host(std::string_view host) const {
  const std::string whole = lower(host);
  const std::size_t colon = whole.rfind(':');
  const bool has_port = colon != std::string::npos && (whole.front() != '[' || colon > whole.find(']'));
  const std::string name = whole.substr(0, has_port ? colon : std::string::npos);
  constexpr unsigned kHttp = 80, kHttps = 443;  // omitted by browsers
  const std::optional<std::uint64_t> port =
      has_port ? number(std::string_view(whole).substr(colon + 1)) : (port_ == kHttps ? kHttps : kHttp);
  if (port != port_) return !token_.empty() && !name.empty();  // for example behind a proxy
  return is_address(name) || name == lower(address_) || !token_.empty();
}

std::optional<Access::Refused> Access::refusal(const RequestHead& head, double now) {
  if (head.host.empty() || !is_own_host(head.host))
    return Refused{
        403, fmt::format(
                 "the Host header is not an address of this server; open it by its IP address, with port {}",
                 port_)};
  if (!head.origin.empty()) {
    const std::string origin = lower(head.origin), host = lower(head.host);
    if (origin != "http://" + host && origin != "https://" + host)
      return Refused{403, "pages of other origins may not use this server", notice_of(origin)};
  }
  if (token_.empty() || same_secret(cookie_value(head.cookie, cookie_name()), session_)) return std::nullopt;
  return refusal_of_token(head, now);
}

/// Nothing tells the author of such a page: a browser does not show scripts why a WebSocket is refused.
std::string Access::notice_of(const std::string& origin) {
  constexpr std::size_t kShown = 100;
  std::string shown = printable(origin.substr(0, kShown));
  if (noticed_.size() == kMostNotices || !noticed_.insert(shown).second) return {};
  return fmt::format(
      "note: refused a web page of another origin, {}; how a page of your own may use this program: "
      "docs/gateway.md, A page of your own",
      shown);
}

std::optional<Access::Refused> Access::refusal_of_token(const RequestHead& head, double now) {
  constexpr std::string_view kBearer = "bearer ";
  const std::string asked = query_value(head.target, "token");
  const std::string_view bearer = lower(head.authorization.substr(0, kBearer.size())) == kBearer
                                      ? head.authorization.substr(kBearer.size())
                                      : std::string_view{};
  for (const std::string_view given : {std::string_view(asked), bearer}) {
    if (given.empty()) continue;
    // The token is not even compared: otherwise the right one could still be recognised.
    if (!head.logged_in && !guesses_.permits(head.address, now))
      return Refused{429, "too many wrong tokens; wait a minute"};
    if (same_secret(given, token_)) {
      guesses_.count_right(head.address);
      return std::nullopt;
    }
    guesses_.count_wrong(head.address, now);
  }
  return Refused{401, "a token is needed: open the address that palpate run prints"};
}

bool Access::has_token_in_target(const RequestHead& head) const {
  return same_secret(query_value(head.target, "token"), token_);
}

std::string Access::cookie_name() const { return fmt::format("palpate-{}", port_); }
std::string Access::cookie() const { return cookie_name() + '=' + session_; }

double GuessLimit::Bucket::level(double now, double again) const {
  return std::max(0.0, filled - (now - at) / again);
}

bool GuessLimit::permits(std::string_view address, double now) const {
  const auto of = of_.find(address);
  if (of != of_.end() && of->second.level(now, kOneAgain) + 1.0 > kOfOne) return false;
  return trusted_.contains(address) || all_.level(now, kAllAgain) + 1.0 <= kOfAll;
}

void GuessLimit::count_wrong(std::string_view address, double now) {
  // The entries left are at most as many as wrong tokens are permitted while an entry is kept.
  std::erase_if(of_, [now](const auto& one) { return one.second.level(now, kOneAgain) == 0.0; });
  Bucket& one = of_[std::string(address)];
  one = {one.level(now, kOneAgain) + 1.0, now};
  if (!trusted_.contains(address)) all_ = {all_.level(now, kAllAgain) + 1.0, now};
}

std::string guesser_at(const std::string& address) {
  in6_addr ip{};
  if (::inet_pton(AF_INET6, address.substr(0, address.find('%')).c_str(), &ip) != 1 ||
      IN6_IS_ADDR_V4MAPPED(&ip))
    return address;
  std::fill(ip.s6_addr + 8, ip.s6_addr + 16, 0);
  std::array<char, INET6_ADDRSTRLEN> network{};
  return ::inet_ntop(AF_INET6, &ip, network.data(), network.size());
}

std::string random_text() {
  std::random_device source;
  std::string text;
  for (int k = 0; k < 4; ++k) text += fmt::format("{:08x}", source());
  return text;
}

std::string token_problem(std::string_view token) {
  const bool plain = std::all_of(token.begin(), token.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '.' || c == '_' || c == '~';
  });
  if (plain && token.size() >= kLeastToken && token.size() <= kMostToken) return {};
  return fmt::format("a token must have {} to {} characters: letters, digits, '-', '.', '_' or '~'",
                     kLeastToken, kMostToken);
}

std::string without_query_value(std::string_view target, std::string_view name) {
  const std::size_t mark = target.find('?');
  std::string result(target.substr(0, mark));
  if (mark == std::string_view::npos) return result;
  char between = '?';
  for (std::string_view query = target.substr(mark + 1); !query.empty();) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view one = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    if (one.empty() || one.substr(0, one.find('=')) == name) continue;
    result += between;
    result += one;
    between = '&';
  }
  return result;
}

std::optional<std::string> path_of(std::string_view target) {
  std::optional<std::string> path = decoded(target.substr(0, target.find_first_of("?#")));
  if (!path || !path->starts_with('/') || path->find("..") != std::string::npos ||
      path->find('\0') != std::string::npos || path->find('\\') != std::string::npos)
    return std::nullopt;
  return path;
}

std::string query_value(std::string_view target, std::string_view name) {
  const std::size_t mark = target.find('?');
  if (mark == std::string_view::npos) return {};
  std::string_view query = target.substr(mark + 1);
  while (!query.empty()) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view one = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    if (one.starts_with(name) && one.substr(name.size()).starts_with('='))
      return decoded(one.substr(name.size() + 1)).value_or("");
  }
  return {};
}

RangeRequest parse_range(std::string_view value, std::uint64_t size) {
  using Kind = RangeRequest::Kind;
  constexpr std::string_view kBytes = "bytes=";
  if (!value.starts_with(kBytes)) return {};
  value.remove_prefix(kBytes.size());
  const std::size_t dash = value.find('-');
  if (dash == std::string_view::npos || value.find(',') != std::string_view::npos) return {};
  const std::string_view before = value.substr(0, dash), after = value.substr(dash + 1);
  if (before.empty()) {  // suffix of `after` bytes
    const auto count = number(after);
    if (!count) return {};
    if (*count == 0 || size == 0) return {Kind::kUnsatisfiable, {}};
    const std::uint64_t most = std::min(*count, size);
    return {Kind::kPart, {size - most, most}};
  }
  const auto first = number(before);
  const auto last = after.empty() ? std::optional<std::uint64_t>(UINT64_MAX) : number(after);
  if (!first || !last || *last < *first) return {};
  if (*first >= size) return {Kind::kUnsatisfiable, {}};
  return {Kind::kPart, {*first, std::min(*last, size - 1) - *first + 1}};
}

}  // namespace palpate
