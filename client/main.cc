// cagefit: the command line client.
#include <exception>
#include <iostream>

#include "client/commands/command.h"
#include "client/commands/parse.h"

int main(int argc, char** argv) try {
  return cagefit::client::RunCommandLine(argc, argv);
} catch (const std::exception& error) {
  std::cerr << "cagefit: " << error.what() << "\n";
  return cagefit::client::kFailed;
}
