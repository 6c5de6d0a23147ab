// What the reference client in C++ makes of a sequence, for the one in JavaScript to be held against: a line
// of figures for every line of standard input that asks for one. tests/web/gateway/both_clients_test.mjs
// writes them.
//
//     limits FORCE_MAX TORQUE_MAX DAMPING          begins anew
//     take FX FY FZ TX TY TZ MEASURED_AT T         a wrench
//     model MEASURED_AT T STIFFNESS DAMPING FRICTION SHARE X Y Z [POINT NORMAL]...
//     fail
//     show T                                       prints the wrench
//     show_at X Y Z T                              likewise
//     ask X Y Z T             the renderer alone, of the newest good model: prints the force, `most`,
//                             `pressed` and the energy
//     shown SHARE             of what it was asked for
//
// Numbers may be nan, infinity and -infinity. SI units.
#include <client/palpate_client.h>

#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>

namespace {

using namespace palpate_client;

/// The words of a line, one after the other.
class Words {
 public:
  explicit Words(const std::string& line) : words_(line) {}
  std::string word() {
    std::string next;
    words_ >> next;
    return next;
  }
  double number() { return std::strtod(word().c_str(), nullptr); }
  Vector vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  bool more() { return !(words_ >> std::ws).eof(); }

 private:
  std::istringstream words_;
};

void print(std::initializer_list<double> numbers) {
  for (const double x : numbers) std::printf("%.17g ", x);
  std::printf("\n");
}

void print(const Wrench& w) {
  print({w.force[0], w.force[1], w.force[2], w.torque[0], w.torque[1], w.torque[2]});
}

LocalModel read_model(Words& words) {
  LocalModel model;
  model.stiffness = words.number();
  model.damping = words.number();
  model.friction = words.number();
  model.share = words.number();
  model.position = words.vector();
  for (; words.more(); ++model.count) {
    const Vector point = words.vector(), normal = words.vector();
    if (model.count < LocalModel::kMost) model.planes[model.count] = {point, normal};
  }
  return model;
}

class Trace {
 public:
  explicit Trace(const Limits& limits) : governor_(limits), renderer_(limits) {}

  void follow(const std::string& what, Words& words) {
    if (what == "take") {
      const Vector force = words.vector(), torque = words.vector();
      const double measured_at = words.number();
      governor_.take({force, torque}, measured_at, words.number());
    } else if (what == "model") {
      const double measured_at = words.number(), t = words.number();
      const LocalModel model = read_model(words);
      governor_.take_model(model, measured_at, t);
      if (is_good(model)) model_ = model;
    } else if (what == "fail") {
      governor_.fail();
    } else if (what == "show") {
      print(governor_.show(words.number()));
    } else if (what == "show_at") {
      const Vector position = words.vector();
      print(governor_.show(position, words.number()));
    } else if (what == "ask") {
      const Vector position = words.vector();
      asked_ = renderer_.ask(model_, position, words.number());
      print({asked_[0], asked_[1], asked_[2], renderer_.most(), renderer_.pressed(), renderer_.energy()});
    } else if (what == "shown") {
      renderer_.show(vectors::scaled(asked_, words.number()));
    }
  }

 private:
  WrenchGovernor governor_;
  LocalRenderer renderer_;
  LocalModel model_;
  Vector asked_{};
};

}  // namespace

int main() {
  std::unique_ptr<Trace> trace;
  for (std::string line; std::getline(std::cin, line);) {
    Words words(line);
    const std::string what = words.word();
    if (what == "limits") {
      const double force_max = words.number(), torque_max = words.number();
      trace = std::make_unique<Trace>(Limits{force_max, torque_max, words.number()});
    } else if (trace) {
      trace->follow(what, words);
    }
  }
}
