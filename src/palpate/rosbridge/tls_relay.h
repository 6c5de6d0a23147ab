/// \file
/// Where the TLS of a web server ends.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

namespace palpate {

/// Takes TLS off connections: what comes over one is decrypted into a pair of sockets of this machine, and
/// what is written into that is encrypted. The server behind it reads and writes as it does without TLS. It
/// has a thread of its own from start() to stop().
class TlsRelay {
 public:
  static constexpr std::size_t kMostHandshakes = 16;  ///< under way; the oldest makes room for the next
  static constexpr double kHandshakeTime = 5.0;       ///< at most. Unit: [s].

  /// \param certificate, key files in PEM: the certificate with its chain, and its private key without a
  /// password \throws Error for a file that cannot be read or is none of these, and for a key that is another
  /// certificate's.
  TlsRelay(const std::string& certificate, const std::string& key);
  ~TlsRelay();
  TlsRelay(const TlsRelay&) = delete;
  TlsRelay& operator=(const TlsRelay&) = delete;

  void start();
  /// Closes all connections.
  void stop();

  /// Takes a connected TCP socket over, and hands on the end without TLS, which belongs to `plain`, once both
  /// sides have agreed; never, if they do not. `plain` is called on the relay's thread. Any thread.
  void take(int socket, std::function<void(int descriptor)> plain);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace palpate
