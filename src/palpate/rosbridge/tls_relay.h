/// \file
/// TLS termination for the web server.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

namespace palpate {

/// Terminates TLS: input of a connection is decrypted into a local socket pair, and output written to it is
/// encrypted. The server behind it reads and writes as without TLS. Runs its own thread from start() to
/// stop().
class TlsRelay {
 public:
  static constexpr std::size_t kMostHandshakes = 16;  ///< in progress; the oldest is dropped for a new one
  static constexpr double kHandshakeTime = 5.0;       ///< timeout. Unit: [s].

  /// \param certificate, key files in PEM: the certificate with its chain, and its private key without a
  /// password \throws Error for a file that cannot be read or has the wrong content, and for a key that does
  /// not match the certificate.
  TlsRelay(const std::string& certificate, const std::string& key);
  ~TlsRelay();
  TlsRelay(const TlsRelay&) = delete;
  TlsRelay& operator=(const TlsRelay&) = delete;

  void start();
  /// Closes all connections.
  void stop();

  /// Takes ownership of a connected TCP socket. After the handshake, passes the plaintext socket to `plain`,
  /// which then owns it; if the handshake fails, `plain` is not called. `plain` runs on the relay's thread.
  /// Any thread.
  void take(int socket, std::function<void(int descriptor)> plain);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace palpate
