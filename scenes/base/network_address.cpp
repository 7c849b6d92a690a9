#include "scenes/base/network_address.h"

#include <charconv>

#include "scenes/base/error.h"

namespace pickbed::scenes {

NetworkAddress ParseNetworkAddress(const std::string& text) {
  constexpr int kMaxPort = 65535;
  const size_t colon = text.rfind(':');
  NetworkAddress address;
  bool ok = colon != std::string::npos && colon > 0;
  if (ok) {
    address.host = text.substr(0, colon);
    const char* end = text.data() + text.size();
    const auto [last, error] = std::from_chars(text.data() + colon + 1, end, address.port);
    ok = error == std::errc() && last == end && address.port >= 1 && address.port <= kMaxPort;
  }
  CheckInput(ok, "'" + text +
                     "' is no address; write host:port with a port from 1 to 65535, for example "
                     "localhost:5555");
  return address;
}

}  // namespace pickbed::scenes
