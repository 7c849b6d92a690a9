#pragma once

// An address host:port of a server.

#include <string>

namespace pickbed::scenes {

struct NetworkAddress {
  std::string host;
  int port = 0;  // 1 to 65535
};

// Reads "host:port". Throws InputError with the text, if the host is missing or the port is no
// whole number from 1 to 65535.
NetworkAddress ParseNetworkAddress(const std::string& text);

}  // namespace pickbed::scenes
