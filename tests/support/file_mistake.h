/// \file
/// What the tests of readers of files go through.
#pragma once

#include <string>

namespace palpate::test {

/// A file with a mistake, the line where it is, and what the message must say.
struct FileMistake {
  std::string text;
  int line;
  const char* words;
};

}  // namespace palpate::test
