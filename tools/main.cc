#include "tools/cli.h"

int main(int argc, char** argv) { return takt::tools::run_command_line(argc, argv); }
