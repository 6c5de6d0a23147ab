extern "C" void touch(const char* path);

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  touch(argv[1]);
}
