#include <palpate/rosbridge/message.h>

#include <cstdint>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <support/cbor.h>
#include <support/random_pairs.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using test::cbor_of;
using test::message_of;
using test::Random;
using testing::HasSubstr;

std::string repeated(const std::string& text, std::size_t n) {
  std::string result;
  for (std::size_t k = 0; k < n; ++k) result += text;
  return result;
}

std::string bytes(std::initializer_list<int> values) {
  std::string result;
  for (const int value : values) result += static_cast<char>(value);
  return result;
}

std::string refusal_of_json(const std::string& text) {
  return message_of<Refusal>([&] { decode_json(text); });
}

std::string refusal_of_cbor(const std::string& text) {
  return message_of<Refusal>([&] { decode_cbor(text); });
}

TEST(DecodeJson, ReadsAnyValue) {
  EXPECT_EQ(decode_json(R"({"op": "publish", "msg": {"x": [1, -2.5, true, null, "\u00e9"]}})"),
            (Json{{"op", "publish"}, {"msg", {{"x", {1, -2.5, true, nullptr, "é"}}}}}));
  EXPECT_EQ(decode_json(" 7 "), Json(7));
}

TEST(DecodeJson, RefusesWhatIsNotOneSoundValue) {
  for (const std::string text :
       {"",       " ",        "{",     "[1, 2", "{\"a\": }", "{'a': 1}",     "[1,]",   "nul",
        "NaN",    "Infinity", "1e999", "01",    "\"\xff\"",  "\"\xc0\xaf\"", "\"\n\"", "\"\\ud800\"",
        "\"open", "1 2",      "{} {}", "[]]",   "// a\n1",   "\xef\xbb"}) {
    EXPECT_THAT(refusal_of_json(text), HasSubstr("not valid JSON")) << text;
  }
  EXPECT_THAT(refusal_of_json(std::string("1\0", 2)), HasSubstr("not valid JSON"));
}

TEST(DecodeJson, TakesAsManyLevelsAsItSaysAndNoMore) {
  const auto arrays = [](std::size_t n, const std::string& core = "") {
    return repeated("[", n) + core + repeated("]", n);
  };
  const auto objects = [](std::size_t n) { return repeated("{\"a\":", n - 1) + "{}" + repeated("}", n - 1); };
  EXPECT_NO_THROW(decode_json(arrays(kMostLevels)));
  EXPECT_NO_THROW(decode_json(arrays(kMostLevels, "1"))) << "a number is no level";
  EXPECT_NO_THROW(decode_json(objects(kMostLevels)));
  EXPECT_THAT(refusal_of_json(arrays(kMostLevels + 1)), HasSubstr("32 levels"));
  EXPECT_THAT(refusal_of_json(arrays(kMostLevels + 1, "1")), HasSubstr("32 levels"));
  EXPECT_THAT(refusal_of_json(objects(kMostLevels + 1)), HasSubstr("32 levels"));
  EXPECT_THAT(refusal_of_json("[[], " + arrays(kMostLevels) + "]"), HasSubstr("32 levels"))
      << "not only first";
  EXPECT_THAT(refusal_of_json(repeated("[", 200'000)), HasSubstr("32 levels"));
}

TEST(DecodeCbor, ReadsWhatEncodersMake) {
  EXPECT_EQ(decode_cbor(bytes({0x00})), Json(0));
  EXPECT_EQ(decode_cbor(bytes({0x18, 0x64})), Json(100));
  EXPECT_EQ(decode_cbor(bytes({0x1b, 0, 0, 0, 0xe8, 0xd4, 0xa5, 0x10, 0})), Json(1'000'000'000'000));
  EXPECT_EQ(decode_cbor(bytes({0x29})), Json(-10));
  EXPECT_EQ(decode_cbor(bytes({0xf9, 0x3e, 0x00})), Json(1.5));              // two bytes
  EXPECT_EQ(decode_cbor(bytes({0xfa, 0x47, 0xc3, 0x50, 0x00})), Json(1e5));  // four
  EXPECT_EQ(decode_cbor(bytes({0xfb, 0x3f, 0xf1, 0x99, 0x99, 0x99, 0x99, 0x99, 0x9a})), Json(1.1));
  EXPECT_EQ(decode_cbor(bytes({0xf4})), Json(false));
  EXPECT_EQ(decode_cbor(bytes({0xf6})), Json(nullptr));
  EXPECT_EQ(decode_cbor(bytes({0x83, 0x01, 0x02, 0x80})), (Json{1, 2, Json::array()}));
  EXPECT_EQ(decode_cbor(bytes({0xa1, 0x62}) + "op" + bytes({0x63}) + "abc"), (Json{{"op", "abc"}}));
  EXPECT_EQ(decode_cbor(bytes({0x78, 0x02}) + "hi"), Json("hi")) << "a length longer than it need be";
}

TEST(DecodeCbor, TakesAsManyLevelsAsItSaysAndNoMore) {
  const auto arrays = [](std::size_t n) { return repeated("\x81", n) + '\x01'; };
  const auto maps = [](std::size_t n) { return repeated(bytes({0xa1, 0x61, 'a'}), n) + '\x01'; };
  EXPECT_NO_THROW(decode_cbor(arrays(kMostLevels)));
  EXPECT_NO_THROW(decode_cbor(maps(kMostLevels)));
  EXPECT_NO_THROW(decode_cbor(repeated("\x81", kMostLevels - 1) + '\x80'));
  EXPECT_THAT(refusal_of_cbor(arrays(kMostLevels + 1)), HasSubstr("32 levels"));
  EXPECT_THAT(refusal_of_cbor(maps(kMostLevels + 1)), HasSubstr("32 levels"));
  EXPECT_THAT(refusal_of_cbor(repeated("\x81", kMostLevels) + '\x80'), HasSubstr("32 levels"));
  EXPECT_THAT(refusal_of_cbor('\x82' + bytes({0x01}) + arrays(kMostLevels)), HasSubstr("32 levels"));
  EXPECT_THAT(refusal_of_cbor(repeated("\x81", 200'000)), HasSubstr("32 levels"));
  // As many as one likes beside each other.
  std::string wide = bytes({0x98, 200});
  EXPECT_NO_THROW(decode_cbor(wide + repeated(arrays(kMostLevels - 1), 200)));
}

TEST(DecodeCbor, RefusesWhatIsTruncatedAnywhere) {
  const std::string whole =
      cbor_of({{"op", "publish"},
               {"msg", {{"x", 0.1}, {"n", 70'000}, {"a", {1, 2, 3}}, {"s", std::string(300, 'x')}}}});
  EXPECT_NO_THROW(decode_cbor(whole));
  for (std::size_t n = 0; n < whole.size(); ++n)
    EXPECT_THAT(refusal_of_cbor(whole.substr(0, n)), HasSubstr("truncated")) << n;
  EXPECT_THAT(refusal_of_cbor(whole + '\0'), HasSubstr("data after the message"));
  EXPECT_THAT(refusal_of_cbor(whole + whole), HasSubstr("data after the message"));
}

TEST(DecodeCbor, RefusesWhatItDoesNotKnow) {
  // Of indefinite length: byte string, text, array, map; and the break that ends them.
  for (const int head : {0x5f, 0x7f, 0x9f, 0xbf})
    EXPECT_THAT(refusal_of_cbor(bytes({head, 0xff})), HasSubstr("indefinite")) << head;
  EXPECT_THAT(refusal_of_cbor(bytes({0xff})), HasSubstr("indefinite"));
  EXPECT_THAT(refusal_of_cbor(bytes({0x82, 0x01, 0xff})), HasSubstr("indefinite"));
  // Reserved.
  for (int major = 0; major < 8; ++major) {
    for (int minor = 28; minor < 31; ++minor)
      EXPECT_THAT(refusal_of_cbor(bytes({major << 5 | minor, 0, 0, 0, 0, 0, 0, 0, 0})), HasSubstr("CBOR"));
  }
  // A date, a typed array, and the mark of CBOR itself.
  for (const std::string& tag : {bytes({0xc1}), bytes({0xd8, 0x56}), bytes({0xd9, 0xd9, 0xf7})})
    EXPECT_THAT(refusal_of_cbor(tag + '\x01'), HasSubstr("tag"));
  EXPECT_THAT(refusal_of_cbor(bytes({0xa1, 0x01, 0x01})), HasSubstr("CBOR")) << "a name that is a number";
  EXPECT_THAT(refusal_of_cbor(bytes({0xe0})), HasSubstr("CBOR")) << "a simple value of nobody";
}

TEST(DecodeCbor, RefusesLengthsThatItCannotHaveAtOnce) {
  // What each says it has: 2^64 - 1, 2^63 (twice which is 0 in 64 bits), 2^32, and one more than there is.
  for (const int major : {2, 3, 4, 5}) {
    const int head = major << 5;
    EXPECT_THAT(refusal_of_cbor(bytes({head | 27, 255, 255, 255, 255, 255, 255, 255, 255})),
                HasSubstr("truncated"));
    EXPECT_THAT(refusal_of_cbor(bytes({head | 27, 128, 0, 0, 0, 0, 0, 0, 0}) + std::string(64, '\x61')),
                HasSubstr("truncated"));
    EXPECT_THAT(refusal_of_cbor(bytes({head | 26, 255, 255, 255, 255}) + std::string(64, '\0')),
                HasSubstr("truncated"));
    EXPECT_THAT(refusal_of_cbor(bytes({head | 24, 65}) + std::string(64, '\0')), HasSubstr("truncated"));
  }
}

/// Any value that JSON and CBOR both have.
Json random_value(Random& random, int levels) {
  switch (random.integer(0, levels > 1 ? 8 : 6)) {
    case 0: return nullptr;
    case 1: return random.integer(0, 1) == 1;
    case 2: return random.integer(std::numeric_limits<int>::min(), std::numeric_limits<int>::max());
    case 3: return std::uint64_t{1} << random.integer(0, 63);
    case 4: return random.either_sign(random.log_uniform(1e-300, 1e300));
    case 5: return std::string(static_cast<std::size_t>(random.integer(0, 300)), 'a');
    case 6: return "\u20ac \\\" \n";
    case 7: {
      Json array = Json::array();
      for (int n = random.integer(0, 30); n > 0; --n) array.push_back(random_value(random, levels - 1));
      return array;
    }
    default: {
      Json object = Json::object();
      for (int n = random.integer(0, 6); n > 0; --n)
        object["key" + std::to_string(random.integer(0, 99))] = random_value(random, levels - 1);
      return object;
    }
  }
}

TEST(Decode, GivesBackWhateverWasEncoded) {
  Random random(1);
  for (int draw = 0; draw < 500; ++draw) {
    const Json value = random_value(random, 5);
    EXPECT_EQ(decode_cbor(cbor_of(value)), value);
    EXPECT_EQ(decode_json(value.dump()), value);
  }
}

TEST(Decode, OfAnyBytesIsAValueOrARefusal) {
  Random random(2);
  int taken = 0, refused = 0;
  const auto attempt = [&](const std::string& frame, bool binary) {
    try {
      binary ? decode_cbor(frame) : decode_json(frame);
      ++taken;
    } catch (const Refusal&) {
      ++refused;
    }
  };
  for (int draw = 0; draw < 20'000; ++draw) {
    std::string frame;
    for (int n = random.integer(0, 40); n > 0; --n) frame += static_cast<char>(random.integer(0, 255));
    attempt(frame, draw % 2 == 0);
  }
  // Sound ones, a few bytes of which are another's.
  for (int draw = 0; draw < 2'000; ++draw) {
    const Json value = random_value(random, 4);
    const bool binary = draw % 2 == 0;
    std::string frame = binary ? cbor_of(value) : value.dump();
    for (int n = random.integer(0, 3); n > 0; --n)
      frame[static_cast<std::size_t>(random.integer(0, static_cast<int>(frame.size()) - 1))] =
          static_cast<char>(random.integer(0, 255));
    attempt(frame, binary);
  }
  EXPECT_GE(taken, 500);
  EXPECT_GE(refused, 5'000);
}

TEST(Fields, AreReadOrRefusedByName) {
  const Json message{{"text", "a"},
                     {"number", 2},
                     {"null", nullptr},
                     {"yes", true},
                     {"list", {1}},
                     {"long", std::string(65'536, 'x')},
                     {"longer", std::string(65'537, 'x')},
                     {"nan", std::numeric_limits<double>::quiet_NaN()},
                     {"inf", std::numeric_limits<double>::infinity()}};
  EXPECT_EQ(text_field(message, "text"), "a");
  EXPECT_EQ(text_field(message, "nowhere"), "");
  EXPECT_EQ(text_field(message, "null"), "");
  EXPECT_EQ(text_field(message, "long").size(), 65'536U);
  for (const char* name : {"number", "yes", "list", "longer"})
    EXPECT_THAT(message_of<Refusal>([&] { text_field(message, name); }), HasSubstr(std::string("'") + name));
  EXPECT_EQ(number_field(message, "number", 7.0), 2.0);
  EXPECT_EQ(number_field(message, "nowhere", 7.0), 7.0);
  for (const char* name : {"text", "null", "yes", "list", "nan", "inf"})
    EXPECT_THAT(message_of<Refusal>([&] { number_field(message, name, 7.0); }),
                HasSubstr(std::string("'") + name + "' must be a finite number"));
  EXPECT_EQ(field(message, "null"), Json(nullptr));
  EXPECT_THAT(message_of<Refusal>([&] { field(message, "nowhere"); }), HasSubstr("'nowhere' is missing"));
}

}  // namespace
}  // namespace palpate
