#include <palpate/rosbridge/access.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr const char* kSession = "session";

/// Status of the refusal; 0 if it is none.
int status(Access& access, const RequestHead& head, double now = 0.0) {
  const auto refused = access.refusal(head, now);
  return refused ? refused->status : 0;
}

int status_of_host(Access& access, std::string_view host) {
  RequestHead head;
  head.host = host;
  head.target = "/";
  return status(access, head);
}

TEST(Access, IsForHostsThatAreAddressesOfThisServer) {
  Access local("127.0.0.1", 9090, "", kSession);
  for (const char* host : {"127.0.0.1:9090", "localhost:9090", "LocalHost:9090", "[::1]:9090",
                           "192.168.1.7:9090", "[FE80::1]:9090"}) {
    EXPECT_EQ(status_of_host(local, host), 0) << host;
  }
}

TEST(Access, KnowsThePortThatABrowserLeavesOut) {
  Access secure("127.0.0.1", 443, "", kSession), plain("127.0.0.1", 80, "", kSession);
  EXPECT_EQ(status_of_host(secure, "127.0.0.1"), 0);
  EXPECT_EQ(status_of_host(plain, "127.0.0.1"), 0);
  EXPECT_EQ(status_of_host(secure, "127.0.0.1:80"), 403);
}

// A page of anybody's may have its own name resolve to this machine, and then ask it as its own origin.
TEST(Access, RefusesNamesOfOthersAndOtherPorts) {
  Access local("127.0.0.1", 9090, "", kSession);
  for (const char* host : {"",
                           "evil.example:9090",
                           "evil.example",
                           "127.0.0.1.evil.example:9090",
                           "localhost.evil.example:9090",
                           "evil-localhost:9090",
                           "1.2.3.4x:9090",
                           "a127.0.0.1:9090",
                           "::1:9090",
                           "127.0.0.1",
                           "localhost",
                           "[::1]",
                           "127.0.0.1:9091",
                           "127.0.0.1:80",
                           "127.0.0.1:",
                           "127.0.0.1:9090x",
                           "127.0.0.1:+9090",
                           "127.0.0.1: 9090",
                           "127.0.0.1:99999999999999999999",
                           ":9090",
                           "[::1",
                           "user@127.0.0.1:9090"}) {
    EXPECT_EQ(status_of_host(local, host), 403) << host;
  }
}

TEST(Access, LeavesOutThePortWhereItIsThatOfHttp) {
  Access web("127.0.0.1", 80, "", kSession);
  for (const char* host : {"127.0.0.1", "127.0.0.1:80", "localhost", "[::1]", "[::1]:80"})
    EXPECT_EQ(status_of_host(web, host), 0) << host;
  EXPECT_EQ(status_of_host(web, "127.0.0.1:9090"), 403);
  EXPECT_EQ(status_of_host(web, "evil.example"), 403);
}

TEST(Access, KnowsTheNameThatItListensOn) {
  Access named("Lab.Example", 9090, "", kSession);
  EXPECT_EQ(status_of_host(named, "lab.example:9090"), 0);
  EXPECT_EQ(status_of_host(named, "lab.example:9091"), 403);
  EXPECT_EQ(status_of_host(named, "x.lab.example:9090"), 403);
}

// Nobody has the token who only has a name; and a proxy has a name and a port of its own.
TEST(Access, TakesAnyNameWithTheToken) {
  Access proxied("0.0.0.0", 9090, "secret", kSession);
  for (const char* host : {"haptics.example", "haptics.example:443", "127.0.0.1:9090"}) {
    EXPECT_EQ(status_of_host(proxied, host), 401) << host;
    RequestHead head;
    head.host = host;
    head.target = "/?token=secret";
    EXPECT_EQ(status(proxied, head), 0) << host;
  }
  EXPECT_EQ(status_of_host(proxied, ""), 403);
  EXPECT_EQ(status_of_host(proxied, ":443"), 403);
}

TEST(Access, IsForPagesOfItsOwnOrigin) {
  Access local("127.0.0.1", 9090, "", kSession);
  const auto with_origin = [&](std::string_view host, std::string_view origin) {
    RequestHead head;
    head.host = host;
    head.origin = origin;
    head.target = "/";
    return status(local, head);
  };
  EXPECT_EQ(with_origin("localhost:9090", ""), 0) << "no browser";
  EXPECT_EQ(with_origin("localhost:9090", "http://localhost:9090"), 0);
  EXPECT_EQ(with_origin("LOCALHOST:9090", "HTTP://localhost:9090"), 0);
  EXPECT_EQ(with_origin("localhost:9090", "https://localhost:9090"), 0) << "behind a proxy that encrypts";
  EXPECT_EQ(with_origin("[::1]:9090", "http://[::1]:9090"), 0);
  for (const char* origin :
       {"null", "file://", "http://evil.example", "http://localhost", "http://localhost:9091",
        "http://127.0.0.1:9090", "http://localhost:9090.evil.example", "http://localhost:9090/",
        "http://evil.example/http://localhost:9090", "ws://localhost:9090", "localhost:9090",
        "chrome-extension://abc", " http://localhost:9090"}) {
    EXPECT_EQ(with_origin("localhost:9090", origin), 403) << origin;
  }
}

TEST(Access, WantsTheTokenInOneOfThreePlaces) {
  Access access("0.0.0.0", 9090, "s3cret", kSession);
  double now = 0.0;  // so far apart, no guess is too many
  const auto with = [&](std::string_view target, std::string_view authorization, std::string_view cookie) {
    RequestHead head{"127.0.0.1:9090", {}, authorization, cookie, target};
    return status(access, head, now += 1e3);
  };
  EXPECT_EQ(with("/", "", ""), 401);

  EXPECT_EQ(with("/?token=s3cret", "", ""), 0);
  EXPECT_EQ(with("/scene?a=b&token=s3cret&c", "", ""), 0);
  EXPECT_EQ(with("/?token=s%33cret", "", ""), 0) << "percent-encoded";
  for (const char* target : {"/?token=", "/?token=s3cre", "/?token=s3cret1", "/?token=S3CRET",
                             "/?token=s3creT", "/?token=s3cret%00", "/?tokens3cret", "/?xtoken=s3cret",
                             "/?TOKEN=s3cret", "/token=s3cret", "/?token=%s3cret"}) {
    EXPECT_EQ(with(target, "", ""), 401) << target;
  }

  EXPECT_EQ(with("/", "Bearer s3cret", ""), 0);
  for (const char* authorization :
       {"s3cret", "Basic s3cret", "Bearer", "Bearer ", "Bearer s3cre", "Bearer s3crets", "Bearer s3crex"}) {
    EXPECT_EQ(with("/", authorization, ""), 401) << authorization;
  }

  EXPECT_EQ(with("/", "", "palpate-9090=session"), 0);
  EXPECT_EQ(with("/", "", "a=1; palpate-9090=session; theme=dark"), 0);
  EXPECT_EQ(with("/", "", "a=1;palpate-9090=session"), 0);
  for (const char* cookie : {"palpate-9090=", "palpate-9090", "palpate-9090=sessio", "palpate-9090=session2",
                             "palpate-9091=session", "xpalpate-9090=session", "palpate=session",
                             "a=palpate-9090=session", "; ;=;", "palpate-9090=s3cret"}) {
    EXPECT_EQ(with("/", "", cookie), 401) << cookie;
  }

  EXPECT_EQ(with("/?token=wrong", "Bearer wrong", "palpate-9090=session"), 0) << "one of them will do";
  EXPECT_EQ(with("/?token=wrong", "Bearer s3cret", ""), 0) << "one of them will do";
}

TEST(Access, TakesNoTokenAfterTooManyWrongOnes) {
  Access access("0.0.0.0", 9090, "s3cret", kSession);
  const auto ask = [&](std::string_view target, std::string_view address, double now) {
    RequestHead head{"127.0.0.1:9090", {}, {}, {}, target, address};
    return status(access, head, now);
  };
  for (int k = 0; k < 5; ++k) EXPECT_EQ(ask("/?token=wrong", "a", 1.0), 401) << k;
  EXPECT_EQ(ask("/?token=wrong", "a", 1.0), 429);
  EXPECT_EQ(ask("/?token=s3cret", "a", 1.0), 429) << "it is not even compared";
  EXPECT_EQ(ask("/", "a", 1.0), 401) << "who brings none guesses nothing";
  EXPECT_EQ(ask("/?token=s3cret", "b", 1.0), 0) << "another address";

  RequestHead with_cookie{"127.0.0.1:9090", {}, {}, "palpate-9090=session", "/", "a"};
  EXPECT_EQ(status(access, with_cookie, 1.0), 0);
  RequestHead logged_in{"127.0.0.1:9090", {}, "Bearer s3cret", {}, "/", "a", true};
  EXPECT_EQ(status(access, logged_in, 1.0), 0) << "on a connection on which it was right before";

  EXPECT_EQ(ask("/?token=s3cret", "a", 10.9), 429);
  EXPECT_EQ(ask("/?token=s3cret", "a", 11.1), 0) << "one is forgotten after ten seconds";
  EXPECT_EQ(ask("/?token=wrong", "a", 11.1), 401);
  EXPECT_EQ(ask("/?token=s3cret", "a", 11.1), 429) << "and one only";
}

TEST(Access, CountsTheWrongTokensOfManyAddressesTogether) {
  Access access("0.0.0.0", 9090, "s3cret", kSession);
  const auto ask = [&](std::string_view target, const std::string& address, double now) {
    RequestHead head{"127.0.0.1:9090", {}, {}, {}, target, address};
    return status(access, head, now);
  };
  EXPECT_EQ(ask("/?token=s3cret", "known", 0.0), 0);
  int compared = 0;
  for (int k = 0; k < 200; ++k) compared += ask("/?token=wrong", std::to_string(k), 1.0) == 401 ? 1 : 0;
  EXPECT_EQ(compared, 50);
  EXPECT_EQ(ask("/?token=s3cret", "new", 1.0), 429);
  EXPECT_EQ(ask("/?token=s3cret", "known", 1.0), 0)
      << "where it was right before, others' guesses do not count";
  for (int k = 0; k < 5; ++k) EXPECT_EQ(ask("/?token=wrong", "known", 1.0), 401) << k;
  EXPECT_EQ(ask("/?token=wrong", "known", 1.0), 429) << "but its own do";
  EXPECT_EQ(ask("/?token=s3cret", "new", 2.1), 0) << "one a second is forgotten";
}

// Two guesses in one request are two.
TEST(Access, CountsEveryWrongToken) {
  Access access("0.0.0.0", 9090, "s3cret", kSession);
  RequestHead head{"127.0.0.1:9090", {}, "Bearer wrong", {}, "/?token=wrong", "a"};
  EXPECT_EQ(status(access, head), 401);
  EXPECT_EQ(status(access, head), 401);
  EXPECT_EQ(status(access, head), 429);
}

// The cookie is nothing that anybody could guess, and one of another run is no guess.
TEST(Access, AnOldCookieIsNoGuess) {
  Access access("0.0.0.0", 9090, "s3cret", kSession);
  RequestHead old{"127.0.0.1:9090", {}, {}, "palpate-9090=of-yesterday", "/", "a"};
  for (int k = 0; k < 100; ++k) EXPECT_EQ(status(access, old), 401);
  RequestHead right{"127.0.0.1:9090", {}, {}, {}, "/?token=s3cret", "a"};
  EXPECT_EQ(status(access, right), 0);
}

TEST(Access, KnowsWhoseAddressHasTheToken) {
  Access access("0.0.0.0", 9090, "s3cret", kSession);
  EXPECT_TRUE(access.has_token_in_target({{}, {}, {}, {}, "/?a=b&token=s3cret"}));
  EXPECT_FALSE(access.has_token_in_target({{}, {}, "Bearer s3cret", {}, "/?token=s3cre"}));
  EXPECT_EQ(access.cookie(), "palpate-9090=session");
  EXPECT_FALSE(Access("0.0.0.0", 9090, "", kSession).has_token_in_target({{}, {}, {}, {}, "/?token="}));
}

TEST(GuesserAt, IsTheNetworkOfAnAddressOfIpv6) {
  EXPECT_EQ(guesser_at("192.168.1.2"), "192.168.1.2");
  EXPECT_EQ(guesser_at("::ffff:192.168.1.2"), "::ffff:192.168.1.2");
  EXPECT_EQ(guesser_at("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::");
  EXPECT_EQ(guesser_at("2001:db8:1:2::"), "2001:db8:1:2::");
  EXPECT_EQ(guesser_at("fe80::1%eth0"), "fe80::");
  EXPECT_EQ(guesser_at("::1"), "::");
  EXPECT_NE(guesser_at("2001:db8:1:3:3:4:5:6"), guesser_at("2001:db8:1:2:3:4:5:6"));
}

TEST(Token, IsLongAndFitsIntoAnAddress) {
  EXPECT_EQ(token_problem("abcdefghijklmnop"), "");
  EXPECT_EQ(token_problem("AZaz09-._~AZaz09"), "");
  EXPECT_EQ(token_problem(random_text()), "");
  EXPECT_NE(random_text(), random_text());
  for (const std::string& bad : {std::string(), std::string("abcdefghijklmno"), std::string(257, 'a'),
                                 std::string("abcdefghijklmno;"), std::string("abcdefghijklmno p"),
                                 std::string("abcdefghijklmno\n"), std::string("abcdefghijklmno\xc3\xa9"),
                                 std::string("abcdefghijklmno&"), std::string("abcdefghijklmno%")})
    EXPECT_NE(token_problem(bad), "") << bad;
}

TEST(WithoutQueryValue, KeepsAllElse) {
  for (const auto& [target, without] :
       std::vector<std::pair<std::string, std::string>>{{"/?token=a", "/"},
                                                        {"/", "/"},
                                                        {"/?", "/"},
                                                        {"/a%20b?token=a&x=1", "/a%20b?x=1"},
                                                        {"/?x=1&token=a", "/?x=1"},
                                                        {"/?x=1&token=a&y=%26", "/?x=1&y=%26"},
                                                        {"/?token=a&token=b", "/"},
                                                        {"/?token", "/"},
                                                        {"/?xtoken=a&tokens=b", "/?xtoken=a&tokens=b"}})
    EXPECT_EQ(without_query_value(target, "token"), without) << target;
}

// RFC 9110, 11.1: the name of a scheme is case-insensitive.
TEST(Access, TakesBearerInAnyCase) {
  Access access("0.0.0.0", 9090, "s3cret", kSession);
  RequestHead head{"127.0.0.1:9090", {}, "bearer s3cret", {}, "/"};
  EXPECT_EQ(status(access, head), 0);
}

// Any web page can send any Origin: what it makes appear on the terminal is bounded in number and in length.
TEST(Access, NamesAFewRefusedOriginsOnce) {
  Access local("127.0.0.1", 9090, "", kSession);
  const auto notice_of = [&](const std::string& origin) {
    RequestHead head;
    head.host = "127.0.0.1:9090";
    head.target = "/";
    head.origin = origin;
    const auto refused = local.refusal(head, 0.0);
    return refused ? refused->notice : "accepted";
  };
  EXPECT_EQ(notice_of("http://127.0.0.1:9090"), "accepted");
  EXPECT_NE(notice_of("http://localhost:5173").find(" http://localhost:5173;"), std::string::npos);
  EXPECT_EQ(notice_of("http://localhost:5173"), "");
  EXPECT_EQ(notice_of("HTTP://localhost:5173"), "");
  const std::string hostile = notice_of("\x1b[31mevil\r\n\xff" + std::string(10000, 'x'));
  EXPECT_LT(hostile.size(), 400U);
  for (const char c : hostile) EXPECT_GE(static_cast<unsigned char>(c), 0x20);
  std::size_t named = 2;
  for (int k = 0; k < 1000; ++k)
    named += notice_of("http://" + std::to_string(k) + ".example").empty() ? 0 : 1;
  EXPECT_EQ(named, Access::kMostNotices);
}

TEST(Access, ATokenDoesNotHelpAPageOfAnotherOrigin) {
  Access access("0.0.0.0", 9090, "s3cret", kSession);
  RequestHead head{"127.0.0.1:9090", "http://evil.example", {}, "palpate-9090=session", "/"};
  EXPECT_EQ(status(access, head), 403);
}

TEST(PathOf, DecodesOnce) {
  EXPECT_EQ(path_of("/"), "/");
  EXPECT_EQ(path_of("/scene"), "/scene");
  EXPECT_EQ(path_of("/a%20b/%C3%A9"), "/a b/\u00e9");
  EXPECT_EQ(path_of("/%6a%6F%6f%7A%39"), "/jooz9") << "each digit at the ends of its range";
  EXPECT_EQ(path_of("/%aa%AF%fa%F9"), "/\xaa\xaf\xfa\xf9");
  EXPECT_EQ(path_of("/a+b"), "/a+b");
  EXPECT_EQ(path_of("/%41"), "/A") << "at the very end";
  EXPECT_EQ(path_of("/scene?token=a#b"), "/scene");
  EXPECT_EQ(path_of("/scene#b?c"), "/scene");
  EXPECT_EQ(path_of("/a%3Fb"), "/a?b");
  EXPECT_EQ(path_of("/%2541"), "/%41") << "what is encoded twice is decoded once";
  EXPECT_EQ(path_of("/%252e%252e/a"), "/%2e%2e/a");
  EXPECT_EQ(path_of("%2Fscene"), "/scene");
}

TEST(PathOf, RefusesWhatClimbsOrIsNoPath) {
  for (const char* target : {"",
                             "?",
                             "scene",
                             "*",
                             "http://127.0.0.1/scene",
                             "/..",
                             "/../etc/passwd",
                             "/a/../../b",
                             "/%2e%2e/a",
                             "/.%2E/a",
                             "/a\\b",
                             "/a%5Cb",
                             "/..%2fa",
                             "/a%00",
                             "/%",
                             "/%4",
                             "/a%",
                             "/a%4",
                             "/%zz",
                             "/%4g",
                             "/%g4",
                             "/%%41",
                             "/% 1",
                             "/%-1"}) {
    EXPECT_EQ(path_of(target), std::nullopt) << target;
  }
  EXPECT_EQ(path_of(std::string_view("/a\0b", 4)), std::nullopt);
}

TEST(QueryValue, IsTheFirstOfItsName) {
  EXPECT_EQ(query_value("/a?b=c", "b"), "c");
  EXPECT_EQ(query_value("/a?x=1&b=c&b=d", "b"), "c");
  EXPECT_EQ(query_value("/a?b=c=d", "b"), "c=d");
  EXPECT_EQ(query_value("/a?b=%26%3d%20", "b"), "&= ");
  EXPECT_EQ(query_value("?b=c", "b"), "c");
  EXPECT_EQ(query_value("/a?&&b=c&", "b"), "c");
  for (const char* target : {"", "/", "/a", "/b=c", "/a?", "/a?b", "/a?bb=c", "/a?ab=c", "/a?b=", "/a?b=%",
                             "/a?b=%4", "/a?c=b", "/a?=c", "/a?&", "/a?%62=c"}) {
    EXPECT_EQ(query_value(target, "b"), "") << target;
  }
}

std::string range_of(std::string_view value, std::uint64_t size) {
  const RangeRequest request = parse_range(value, size);
  switch (request.kind) {
    case RangeRequest::Kind::kNone: return "none";
    case RangeRequest::Kind::kUnsatisfiable: return "unsatisfiable";
    default: return std::to_string(request.range.first) + '+' + std::to_string(request.range.count);
  }
}

TEST(ParseRange, AsRfc9110HasIt) {
  EXPECT_EQ(range_of("bytes=0-499", 10'000), "0+500");
  EXPECT_EQ(range_of("bytes=500-999", 10'000), "500+500");
  EXPECT_EQ(range_of("bytes=-500", 10'000), "9500+500");
  EXPECT_EQ(range_of("bytes=9500-", 10'000), "9500+500");
  EXPECT_EQ(range_of("bytes=0-0", 10'000), "0+1");
  EXPECT_EQ(range_of("bytes=-1", 10'000), "9999+1");
  EXPECT_EQ(range_of("bytes=9999-9999", 10'000), "9999+1");
  EXPECT_EQ(range_of("bytes=0-", 10'000), "0+10000");
  // What goes beyond the end ends there.
  EXPECT_EQ(range_of("bytes=9999-10000", 10'000), "9999+1");
  EXPECT_EQ(range_of("bytes=0-18446744073709551615", 10'000), "0+10000");
  EXPECT_EQ(range_of("bytes=-20000", 10'000), "0+10000");
}

TEST(ParseRange, CannotSatisfyWhatBeginsBeyondTheEnd) {
  EXPECT_EQ(range_of("bytes=10000-", 10'000), "unsatisfiable");
  EXPECT_EQ(range_of("bytes=10000-10001", 10'000), "unsatisfiable");
  EXPECT_EQ(range_of("bytes=18446744073709551615-", 10'000), "unsatisfiable");
  EXPECT_EQ(range_of("bytes=-0", 10'000), "unsatisfiable");
  for (const char* value : {"bytes=0-", "bytes=0-0", "bytes=-1", "bytes=-0"})
    EXPECT_EQ(range_of(value, 0), "unsatisfiable") << value << " of an empty file";
}

TEST(ParseRange, IsNoneOfWhatItDoesNotKnow) {
  for (const char* value : {"",
                            "bytes",
                            "bytes=",
                            "bytes=-",
                            "bytes=--1",
                            "bytes=5-4",
                            "bytes=a-b",
                            "bytes=0x0-1",
                            "bytes=1",
                            "bytes=+1-2",
                            "bytes=1-+2",
                            "bytes=1.0-2",
                            "bytes= 1-2",
                            "bytes=1-2 ",
                            "bytes=0-1,3-4",
                            "bytes=0-1,",
                            "items=0-1",
                            "=0-1",
                            "0-1",
                            "bytes=0-1-2",
                            "bytes=-1-2",
                            "bytes=99999999999999999999-",
                            "bytes=0-99999999999999999999"}) {
    EXPECT_EQ(range_of(value, 10), "none") << value;
  }
}

}  // namespace
}  // namespace palpate
