// The format of a file is told by its content, and only then by its name.
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <palpate/base/error.h>
#include <palpate/scene/load_scene.h>

#include "support/ply_builder.h"
#include "support/temporary_file.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

std::string splat_bytes() {
  std::string bytes;
  for (const double v : {1.0, 2.0, 3.0, 0.1, 0.1, 0.1}) bytes += bytes_as<float>(v, false);
  return bytes + std::string("\x01\x02\x03\xff\xff\x80\x80\x80");
}

std::string refusal_of_file(const std::string& bytes, const std::string& name) {
  const TemporaryFile file(bytes, name);
  const std::string message = message_of<Error>([&] { load_scene(file.path()); });
  EXPECT_THAT(message, HasSubstr(file.path()));
  return message;
}

TEST(LoadScene, TellsAPlyByItsContentWhateverItsName) {
  for (const char* name : {"a.ply", "a.PLY", "a.splat", "a.txt", "a", ".ply", "a.ply.gz"}) {
    const TemporaryFile file(inria_file(2).bytes(), name);
    const GaussianScene scene = load_scene(file.path());
    EXPECT_EQ(scene.size(), 2U) << name;
    EXPECT_EQ(scene.source, file.path());
    EXPECT_THAT(scene.format, HasSubstr("INRIA .ply"));
  }
}

TEST(LoadScene, TellsASplatByItsExtensionInAnyCase) {
  for (const char* name : {"a.splat", "a.SPLAT", "a.b.Splat"}) {
    const TemporaryFile file(splat_bytes(), name);
    EXPECT_EQ(load_scene(file.path()).format, ".splat") << name;
  }
}

TEST(LoadScene, DoesNotTakeASplatForAPly) {
  EXPECT_THAT(refusal_of_file(splat_bytes(), "a.ply"), HasSubstr("not a .ply"));
  EXPECT_THAT(refusal_of_file(splat_bytes(), "a.PLY"), HasSubstr("not a .ply"));
  EXPECT_THAT(refusal_of_file(splat_bytes(), "a.bin"), HasSubstr("neither .ply nor .splat"));
  EXPECT_THAT(refusal_of_file("plyx", "a.ply"), HasSubstr("not a .ply"));
  EXPECT_THAT(refusal_of_file("ply", "a.ply"), HasSubstr("not a .ply"));
}

TEST(LoadScene, NamesTheFormatsItCannotRead) {
  EXPECT_THAT(refusal_of_file("\x1f\x8b\x08 gzip", "a.spz"), HasSubstr("gzip"));
  EXPECT_THAT(refusal_of_file("\x1f\x8b\x08 gzip", "a.ply"), HasSubstr("gzip"));
  EXPECT_THAT(refusal_of_file("PK\x03\x04 zip", "a.sog"), HasSubstr("zip"));
  EXPECT_THAT(refusal_of_file("glTF binary", "a.glb"), HasSubstr("glTF"));
  EXPECT_THAT(refusal_of_file("{\"means\":1}", "meta.json"), HasSubstr("JSON"));
  EXPECT_THAT(refusal_of_file("NGSP rest", "a.spz"), HasSubstr("SPZ"));
  EXPECT_THAT(refusal_of_file("ply\nformat binary_little_endian 1.0\nelement chunk 0\nproperty float min_x\n"
                              "element vertex 1\nproperty uint packed_position\nend_header\n\0\0\0\0",
                              "a.compressed.ply"),
              HasSubstr("compressed"));
}

TEST(LoadScene, RefusesWhatIsNotAFileOfSomething) {
  EXPECT_THAT(refusal_of_file("", "a.ply"), HasSubstr("is empty"));
  EXPECT_THAT(refusal_of_file("", "a.splat"), HasSubstr("is empty"));
  const TemporaryFile file("x");
  const auto message = [](const std::string& path) { return message_of<Error>([&] { load_scene(path); }); };
  EXPECT_THAT(message(file.folder() / "missing.ply"), HasSubstr("No such file"));
  EXPECT_THAT(message(file.folder()), HasSubstr("is a folder"));
  const std::string fifo = file.folder() / "fifo.ply";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THAT(message(fifo), HasSubstr("not a regular file"));  // and does not wait for a writer
}

TEST(LoadScene, ReportsProgressThatOnlyGrowsAndEnds) {
  const TemporaryFile file(inria_file(1000).bytes(), "a.ply");
  double last = 0.0;
  load_scene(file.path(), [&](std::string_view stage, double fraction) {
    EXPECT_EQ(stage, "reading");
    EXPECT_GE(fraction, last);
    EXPECT_LE(fraction, 1.0);
    last = fraction;
  });
  EXPECT_EQ(last, 1.0);
}

}  // namespace
}  // namespace palpate::test
