#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/csv.h>
#include <palpate/base/error.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using test::message_of;
using test::TemporaryFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

CsvTable table_of(const std::string& text) { return read_csv(TemporaryFile(text, "t.csv").path()); }
std::string message_for(const std::string& text) {
  return message_of<Error>([&] { table_of(text); });
}

TEST(Csv, ReadsATable) {
  const TemporaryFile file("t,x,y\n0,1.5,-2\n0.001,1e-3,.5\n", "t.csv");
  const CsvTable table = read_csv(file.path());
  EXPECT_EQ(table.source, file.path());
  EXPECT_THAT(table.columns, ElementsAre("t", "x", "y"));
  EXPECT_THAT(table.values, ElementsAre(0, 1.5, -2, 0.001, 1e-3, 0.5));
  EXPECT_EQ(table.rows(), 2U);
  EXPECT_EQ(table.at(1, 2), 0.5);
  EXPECT_EQ(table.column("y"), 2U);
  EXPECT_TRUE(table.has("x"));
  EXPECT_FALSE(table.has("z"));
}

TEST(Csv, TakesAnyLineEndAndSpaceAndBlankLines) {
  const std::vector<double> expected{1, 2, 3, 4};
  EXPECT_EQ(table_of("a,b\r\n1,2\r\n3,4\r\n").values, expected);
  EXPECT_EQ(table_of("a,b\n1,2\n3,4").values, expected);
  EXPECT_EQ(table_of("a,b\n\n1,2\n  \n\r\n3,4\n\n").values, expected);
  EXPECT_EQ(table_of(" a ,\tb\n 1 , 2\n3,\t4 \n").values, expected);
  EXPECT_THAT(table_of(" a ,\tb\r\n").columns, ElementsAre("a", "b"));
}

TEST(Csv, AByteOrderMarkIsNoPartOfAName) {
  for (const std::string start : {"\xef\xbb\xbf", "\t\xef\xbb\xbf ", "\xef\xbb\xbf\xef\xbb\xbf"})
    EXPECT_THAT(table_of(start + "a,b\n").columns, ElementsAre("a", "b"));
}

TEST(Csv, AHeaderAloneIsATableWithoutRows) { EXPECT_EQ(table_of("a,b\n").rows(), 0U); }

TEST(Csv, ACommentIsReadApartFromTheTable) {
  const CsvTable table = table_of("# one\n#two \r\n#\n#  three\na,b\n1,2\n");
  EXPECT_EQ(table.comment, "one\ntwo\n\n three\n");
  EXPECT_THAT(table.columns, ElementsAre("a", "b"));
  EXPECT_EQ(table.line, 5U);
  EXPECT_EQ(table.values, (std::vector<double>{1, 2}));
  EXPECT_EQ(table.lines, std::vector<std::size_t>{6});
  EXPECT_EQ(table_of("\xef\xbb\xbf# one\na\n").comment, "one\n");
  EXPECT_EQ(table_of("a\n1\n").comment, "");
}

TEST(Csv, ACommentIsReadAsItWasWritten) {
  const std::string text = "[made]\nversion = \"1\"\n\ntool = '''\n[[ellipsoid]]\n  '''\n";
  EXPECT_EQ(table_of(csv_comment("[made]\n\nx = 1\n") + "a\n").comment, "[made]\n\nx = 1\n");
  EXPECT_EQ(csv_comment(text).find("\n["), std::string::npos) << "every line is one of a comment";
  EXPECT_EQ(csv_comment("no end"), "# no end\n");
  EXPECT_EQ(csv_comment(""), "");
}

TEST(Csv, RefusesACommentThatHasNoEndOrNoTable) {
  EXPECT_THAT(message_for("# one\n# two\n"), HasSubstr("empty"));
  EXPECT_THAT(message_for("# one\na,,c\n"), AllOf(HasSubstr("line 2"), HasSubstr("column 2")));
  EXPECT_THAT(message_for("a,b\n# late\n1,2\n"), AllOf(HasSubstr("line 2"), HasSubstr("'a'")));
  std::string endless;
  while (endless.size() <= CsvReader::kMaxComment) endless += "# " + std::string(1000, 'x') + "\n";
  EXPECT_THAT(message_for(endless + "a\n1\n"), HasSubstr("comment"));
}

TEST(Csv, RefusesWhatIsNotATable) {
  EXPECT_THAT(message_for(""), AllOf(HasSubstr("t.csv"), HasSubstr("empty")));
  EXPECT_THAT(message_for("a,,c\n"), AllOf(HasSubstr("t.csv"), HasSubstr("line 1"), HasSubstr("column 2")));
  EXPECT_THAT(message_for("a,b,a\n"), AllOf(HasSubstr("t.csv"), HasSubstr("line 1"), HasSubstr("'a'")));
}

TEST(Csv, NamesTheLineOfARowOfTheWrongLength) {
  EXPECT_THAT(message_for("a,b\n1,2\n3\n"),
              AllOf(HasSubstr("t.csv"), HasSubstr("line 3"), HasSubstr("truncated")));
  EXPECT_THAT(message_for("a,b\n\n\n1,2\n\n3\n"), HasSubstr("line 6"));  // blank lines count as lines
  EXPECT_THAT(message_for("a,b\n1,2,3\n"), AllOf(HasSubstr("t.csv"), HasSubstr("line 2")));
}

TEST(Csv, NamesLineAndColumnOfWhatIsNoNumber) {
  for (const std::string cell :
       {"nan", "NaN", "inf", "-inf", "1e999", "", "x", "1.0x", "1 2", "--1", "0x10", "1;2"}) {
    EXPECT_THAT(
        message_for("a,bee,c\n1,2,3\n4," + cell + ",6\n"),
        AllOf(HasSubstr("t.csv"), HasSubstr("line 3"), HasSubstr("'bee'"), HasSubstr("'" + cell + "'")));
  }
}

TEST(Csv, AnIgnoredColumnMayHoldAnything) {
  const TemporaryFile file("a,b,c\n1,two,3\n4,,6\n7,nan,8\n", "t.csv");
  CsvReader reader(file.path());
  const std::vector<std::string_view> wanted{"a", "c", "d"};
  reader.ignore_all_but(wanted);
  const CsvTable table = read_csv(reader);
  EXPECT_EQ(table.values, (std::vector<double>{1, 0, 3, 4, 0, 6, 7, 0, 8}));
  CsvReader strict(file.path());
  strict.ignore(0);
  EXPECT_THAT(message_of<Error>([&] { read_csv(strict); }), AllOf(HasSubstr("line 2"), HasSubstr("'b'")));
}

TEST(Csv, SaysWhatAFileOfAnotherKindIs) {
  EXPECT_THAT(message_for("ply\nformat ascii 1.0\n"), HasSubstr(".ply file"));
  EXPECT_THAT(message_for("a;b\n1;2\n"), AllOf(HasSubstr("line 1"), HasSubstr("semicolons")));
  EXPECT_THAT(message_for("# one\na\tb\n1\t2\n"), AllOf(HasSubstr("line 2"), HasSubstr("tabs")));
  EXPECT_THAT(message_for("0,1,2\n3,4,5\n"), AllOf(HasSubstr("line 1"), HasSubstr("no column names")));
  EXPECT_THAT(message_for(std::string("\0\0,b\n", 5)), AllOf(HasSubstr("line 1"), HasSubstr("binary")));
  EXPECT_THAT(table_of("0,b\n1,2\n").columns, ElementsAre("0", "b"));
}

TEST(Csv, AMessageIsOneLineWhateverTheFileHolds) {
  const std::string message = message_for("a\n\x1b[31m\x01\n");
  EXPECT_THAT(message, AllOf(HasSubstr("line 2"), Not(HasSubstr("\x1b")), Not(HasSubstr("\n"))));
}

TEST(Csv, NamesAMissingColumn) {
  const CsvTable table = table_of("a,b\n1,2\n");
  EXPECT_THAT(message_of<Error>([&] { table.column("force"); }),
              AllOf(HasSubstr("t.csv"), HasSubstr("'force'")));
}

TEST(Csv, RefusesAMissingFileAndAFolder) {
  const TemporaryFile file("");
  EXPECT_THAT(message_of<Error>([&] { read_csv(file.path() + ".no"); }), HasSubstr(".no"));
  EXPECT_THAT(message_of<Error>([&] { read_csv(file.folder().string()); }), HasSubstr("folder"));
}

TEST(Csv, NumbersReadBackToTheBit) {
  std::vector<double> numbers{0.0,
                              -0.0,
                              0.1,
                              1.0 / 3.0,
                              1e23,
                              -5e-324,
                              2.2250738585072011e-308,
                              std::numeric_limits<double>::max(),
                              std::numeric_limits<double>::min(),
                              123456789012345678.0,
                              4294967295.0};
  std::mt19937_64 engine(101);
  while (numbers.size() < 20000) {
    const auto v = std::bit_cast<double>(engine());
    if (std::isfinite(v)) numbers.push_back(v);
  }
  std::string text = "a,b\n";
  for (std::size_t i = 0; i + 1 < numbers.size(); i += 2)
    append_csv_row(text, std::vector{numbers[i], numbers[i + 1]});
  const CsvTable table = table_of(text);
  ASSERT_EQ(table.values.size(), numbers.size() / 2 * 2);
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(table.values[i]), std::bit_cast<std::uint64_t>(numbers[i]))
        << numbers[i];
  }
}

TEST(Csv, RowsAreCommaSeparatedAndShort) {
  std::string text = "x\n";
  append_csv_row(text, std::vector{0.1, 2.0, -3.5});
  append_csv_row(text, std::vector{1e-7});
  EXPECT_EQ(text, "x\n0.1,2,-3.5\n1e-07\n");
}

/// What a CsvReader that takes a cut last line says to "a,b\n1,2\n" and these bytes.
std::string outcome_of(const std::string& tail) {
  const TemporaryFile file("a,b\n1,2\n" + tail, "t.csv");
  CsvReader reader(file.path(), CsvReader::LastLine::kMaybeCut);
  std::size_t rows = 0;
  try {
    while (reader.next()) ++rows;
  } catch (const Error& error) {
    return error.what();
  }
  return std::to_string(rows) + (reader.cut() ? " cut" : "");
}

TEST(CsvReader, LeavesOutALastLineThatIsCut) {
  for (const std::string tail : {"3", "3,", "3,-", "3,1e", "3,1.5e-", "-", "3,.", "\n\n3,"})
    EXPECT_EQ(outcome_of(tail), "1 cut") << tail;
  EXPECT_EQ(outcome_of("3,4\n5"), "2 cut");
  EXPECT_EQ(outcome_of("3,4"), "2");  // nothing tells that it is
  EXPECT_EQ(outcome_of("  "), "1");
}

TEST(CsvReader, TakesWordsWhereItIsToldTo) {
  constexpr std::array<std::string_view, 3> kWords{"red", "green", "grey"};
  const auto last_of = [&](const std::string& text) -> std::string {
    const TemporaryFile file("a,b\n" + text, "t.csv");
    CsvReader reader(file.path(), CsvReader::LastLine::kMaybeCut);
    reader.take_words(1, kWords);
    try {
      double last = -1.0;
      while (const auto row = reader.next()) last = (*row)[1];
      return reader.cut() ? "cut" : std::to_string(static_cast<int>(last));
    } catch (const Error& error) {
      return error.what();
    }
  };
  EXPECT_EQ(last_of("1,red\n"), "0");
  EXPECT_EQ(last_of("1, grey \n"), "2");
  EXPECT_EQ(last_of("1,2\n"), "2") << "as earlier files have it";
  EXPECT_EQ(last_of("1,gre"), "cut");
  EXPECT_THAT(last_of("1,blue\n"),
              AllOf(HasSubstr("line 2"), HasSubstr("'b'"), HasSubstr("red, green, grey")));
  EXPECT_THAT(last_of("1,blue"), HasSubstr("'blue'"));
  EXPECT_THAT(last_of("red,1\n"), HasSubstr("'a'"));
}

TEST(CsvReader, RefusesALastLineThatIsMoreThanCut) {
  EXPECT_THAT(outcome_of("x,4"), AllOf(HasSubstr("line 3"), HasSubstr("'a'")));
  EXPECT_THAT(outcome_of(",4"), HasSubstr("'a'"));
  EXPECT_THAT(outcome_of("3,nan"), HasSubstr("'b'"));
  EXPECT_THAT(outcome_of("3,4,5"), HasSubstr("more than 2"));
  EXPECT_THAT(outcome_of("3\n"), AllOf(HasSubstr("line 3"), HasSubstr("truncated")));
  EXPECT_THAT(outcome_of("3,\n"), AllOf(HasSubstr("line 3"), HasSubstr("'b'")));
  EXPECT_THAT(outcome_of("3\n5,6\n"), AllOf(HasSubstr("line 3"), HasSubstr("truncated")));
}

TEST(CsvReader, SeeksTheLineThatBeginsBehindAByte) {
  const std::string text = "a,b\n1,2\n33,4\n\n5,6\n7,8";
  const TemporaryFile file(text, "t.csv");
  CsvReader reader(file.path());
  for (std::size_t offset = 3; offset < text.size(); ++offset) {
    reader.seek(offset);
    std::size_t start = text.find('\n', offset);
    start = start == std::string::npos ? text.size() : start + 1;
    if (start < text.size() && text[start] == '\n') ++start;  // the blank line
    const auto row = reader.next();
    ASSERT_EQ(row.has_value(), start < text.size()) << offset;
    if (!row) continue;
    EXPECT_EQ((*row)[0], std::stod(text.substr(start))) << offset;
    EXPECT_EQ(reader.row_start(), start) << offset;
    EXPECT_EQ(reader.where(), "byte " + std::to_string(start));
  }
}

TEST(CsvReader, NamesTheByteBehindASeek) {
  const TemporaryFile file("a,b\n1,2\n3,x\n", "t.csv");
  CsvReader reader(file.path());
  reader.seek(3);
  reader.next();
  EXPECT_THAT(message_of<Error>([&] { reader.next(); }), AllOf(HasSubstr("byte 8"), HasSubstr("'b'")));
}

TEST(Csv, ReportsProgressOnLongFiles) {
  std::string text = "a\n";
  for (int i = 0; i < 200000; ++i) text += "1\n";
  const TemporaryFile file(text);
  std::vector<double> fractions;
  EXPECT_EQ(read_csv(file.path(), [&](std::string_view, double f) { fractions.push_back(f); }).rows(),
            200000U);
  EXPECT_GE(fractions.size(), 2U);
  for (const double f : fractions) EXPECT_TRUE(f >= 0.0 && f <= 1.0) << f;
}

}  // namespace
}  // namespace palpate
