#include <cstdint>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/base/toml_file.h>
#include <palpate/base/toml_nesting.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using test::message_of;
using test::TemporaryFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TomlFile file_of(const std::string& text) { return TomlFile(TemporaryFile(text, "f.toml").path()); }

/// What use(root) of a file of this text complains of.
template <typename Use>
std::string complaint(const std::string& text, const Use& use) {
  const TomlFile file = file_of(text);
  return message_of<Error>([&] {
    TomlTable root = file.root();
    use(root);
  });
}

auto names(std::size_t line, const std::string& rest) {
  return AllOf(HasSubstr("f.toml: line " + std::to_string(line) + ": "), HasSubstr(rest));
}

TEST(TomlFile, GivesWhatItIsAskedFor) {
  const TomlFile file = file_of(
      "yes = true\nname = \"a \\u00e9\"\ncount = -3\nx = 0.1\nwhole = 2\nv = [1, 2.5, -3e-2]\n"
      "inner = { a = 1 }\n[[row]]\nk = 1\n[[row]]\nk = 2\n");
  TomlTable root = file.root();
  EXPECT_TRUE(root.at("yes").boolean());
  EXPECT_EQ(root.at("name").text(), "a \u00e9");
  EXPECT_EQ(root.at("count").integer(-3, 0), -3);
  EXPECT_EQ(root.at("x").number(), 0.1);
  EXPECT_EQ(root.at("whole").number(2.0, 2.0), 2.0);
  EXPECT_THAT(root.at("v").numbers<3>(), ElementsAre(1.0, 2.5, -3e-2));
  EXPECT_EQ(root.at("v").items().size(), 3U);
  EXPECT_EQ(root.at("inner").table().at("a").integer(0, 1), 1);
  std::vector<TomlTable> rows = root.at("row").tables();
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1].at("k").integer(0, 9), 2);
  EXPECT_EQ(rows[1].line(), 10U);
  EXPECT_FALSE(root.find("nothing"));
  root.refuse_others();
}

TEST(TomlFile, RefusesWhatIsNotAsExpected) {
  const auto x = [](auto read) { return [read](TomlTable& root) { read(root.at("x")); }; };
  const auto number = x([](const TomlValue& v) { v.number(0.0, 10.0); });
  EXPECT_THAT(complaint("\nx = -1", number), names(2, "'x' must be a number from 0 to 10, not -1"));
  EXPECT_THAT(complaint("x = 10.5", number), names(1, "not 10.5"));
  EXPECT_THAT(complaint("x = nan", number), names(1, "not nan"));
  EXPECT_THAT(complaint("x = true", number), names(1, "not true"));
  EXPECT_THAT(complaint("x = '1'", number), names(1, "not '1'"));
  EXPECT_THAT(complaint("x = [1]", number), names(1, "not an array of 1"));
  EXPECT_THAT(complaint("x = 2001-01-01", number), names(1, "not a date"));
  EXPECT_THAT(complaint("x = inf", x([](const TomlValue& v) { v.number(); })), names(1, "a finite number"));
  const auto vector = x([](const TomlValue& v) { v.numbers<3>(); });
  EXPECT_THAT(complaint("x = [1, 2]", vector), names(1, "an array of 3 numbers, not an array of 2"));
  EXPECT_THAT(complaint("x = 1", vector), names(1, "an array of 3 numbers"));
  EXPECT_THAT(complaint("x = [1,\n2,\n[3]]", vector), names(3, "a finite number"));
  const auto integer = x([](const TomlValue& v) { v.integer(0, 9); });
  EXPECT_THAT(complaint("x = 10", integer), names(1, "a whole number from 0 to 9"));
  EXPECT_THAT(complaint("x = 1.0", integer), names(1, "a whole number"));
  EXPECT_THAT(complaint("x = 1", x([](const TomlValue& v) { v.text(); })), names(1, "text"));
  EXPECT_THAT(complaint("x = 1", x([](const TomlValue& v) { v.boolean(); })), names(1, "true or false"));
  EXPECT_THAT(complaint("x = 1", x([](const TomlValue& v) { v.table(); })), names(1, "a table"));
  const auto tables = x([](const TomlValue& v) { v.tables(); });
  EXPECT_THAT(complaint("[x]", tables), names(1, "[[x]]"));
  EXPECT_THAT(complaint("x = [\n1]", tables), names(2, "a table"));
}

TEST(TomlFile, NamesWhatIsMissingAndWhatNobodyAskedFor) {
  EXPECT_THAT(complaint("\n[t]\na = 1", [](TomlTable& root) { root.at("t").table().at("radius"); }),
              names(2, "'radius' is missing"));
  EXPECT_THAT(complaint("a = 1\nb = 2\nbb = 3",
                        [](TomlTable& root) {
                          root.find("a");
                          root.find("b");
                          root.find("c");
                          root.refuse_others();
                        }),
              names(3, "unknown key 'bb'; the known keys are a, b, c"));
}

TEST(TomlFile, RefusesWhatIsNoToml) {
  EXPECT_THAT(message_of<Error>([] { file_of("a = 1\nb = "); }), names(2, ""));
  EXPECT_THAT(message_of<Error>([] { file_of("a = 1\na = 2"); }), names(2, ""));
  EXPECT_THAT(message_of<Error>([] { TomlFile("no/such.toml"); }), HasSubstr("no/such.toml"));
  const TemporaryFile large(std::string(100, '#'), "f.toml");
  EXPECT_THAT(message_of<Error>([&] { TomlFile(large.path(), 99); }), HasSubstr("100 bytes"));
  EXPECT_EQ(TomlFile(large.path(), 100).root().values().size(), 0U);
}

TEST(TomlNesting, IsThatOfBracketsBracesAndDots) {
  const auto line = [](const std::string& text) { return line_nested_deeper(text, 3).value_or(0); };
  EXPECT_EQ(line("a.b.c.d = 1"), 0U);
  EXPECT_EQ(line("\na.b.c.d.e = 1"), 2U);
  EXPECT_EQ(line("[a.b.c]\nx.y.z.w = [1.5, 2.5, 3.5, 4.5]"), 2U);  // three dots, a bracket
  EXPECT_EQ(line("x = [[1.5, 2.5], [3.5, 4.5]]\ny = [[[1]]]"), 0U);
  EXPECT_EQ(line("x = [\n[\n[\n[\n"), 4U);
  EXPECT_EQ(line("x.y = {a.b = {"), 1U);
  EXPECT_EQ(line("x = {a.b = 1, c.d = 1, e.f = 1}"), 0U);
  EXPECT_EQ(line("[[a]]\n[[a]]\n[[a]]\n[[a]]"), 0U);
  EXPECT_EQ(line("]]]]\na.b.c.d = 1"), 0U);
}

TEST(TomlNesting, IsNotThatOfStringsAndComments) {
  const auto line = [](const std::string& text) { return line_nested_deeper(text, 3).value_or(0); };
  EXPECT_EQ(line("a = '[[[['\nb = \"....\" # ....\n# [[[["), 0U);
  EXPECT_EQ(line("a = \"\\\"[[[[\""), 0U);
  EXPECT_EQ(line("a = '\\'\nb = [[[[1]]]]"), 2U);
  EXPECT_EQ(line("a = ''\nb = [[[[1]]]]"), 2U);
  EXPECT_EQ(line("a = '''\n[[[['[[[['''''\nb = [[[[1]]]]"), 3U);
  EXPECT_EQ(line("'a,b'.\",\".c.',' = 1"), 0U);
  EXPECT_EQ(line("'a,b'.\",\".c.','.d = 1"), 1U);
  EXPECT_EQ(line("a = \"[[[["), 0U);
  EXPECT_EQ(line("a = \"\\"), 0U);
}

/// `begin`, then `unit` so many times, then `end`.
std::string deep(std::string begin, int times, const std::string& unit, const std::string& end = "") {
  for (int k = 0; k < times; ++k) begin += unit;
  return begin + end;
}

TEST(TomlFile, RefusesWhatWouldEndTheStack) {
  for (const std::string& text :
       {deep("x = ", 30000, "["), deep("x = ", 5000, "[\n"), deep("", 30000, "a.", "a = 1"),
        deep("", 9000, "'='.", "a = 1"), deep("[", 30000, "a.", "a]"), deep("x = ", 9000, "{a = "),
        deep(deep("", 60, "a.", "a = {"), 60, "a.", "a = 1}")}) {
    EXPECT_THAT(message_of<Error>([&] { file_of(text); }), HasSubstr("is nested more")) << text.substr(0, 20);
  }
  EXPECT_EQ(file_of(deep("", 99, "a.", "a = 1")).root().values().size(), 1U);
  EXPECT_EQ(file_of(deep("x = ", 99, "[", std::string(99, ']'))).root().values().size(), 1U);
}

}  // namespace
}  // namespace palpate
