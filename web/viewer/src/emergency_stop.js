// The user's emergency stop. It is the only request that is sent again: in a new connection, until the program has
// confirmed it. A stop that arrives late still stops; a pose or a resume that arrives late would move the hand.

const shownAfter = 250; // time without an answer after which the stop is shown as not confirmed. Unit: [ms].
const repeatAfter = 1000; // delay of the next attempt after a refusal. Unit: [ms].

export class EmergencyStop {
  #since = null; // time of the first press that is not confirmed. Unit: [ms].
  #presses = 0;
  #newest = 0; // number of the newest attempt
  #timer = 0;

  constructor(connection) {
    this.connection = connection;
    connection.onChange((connected) => { if (connected && this.#since !== null) this.#send(); });
  }

  get presses() {
    return this.#presses;
  }

  press() {
    this.#presses += 1;
    this.#since ??= performance.now();
    return this.#send();
  }

  /// Ends the attempts: the program has confirmed a resume of this page that was sent after so many presses. A stop that
  /// was pressed since is not ended.
  forget(presses) {
    if (presses !== this.#presses) return;
    this.#since = null;
    clearTimeout(this.#timer);
  }

  /// Whether the force may be on although the user has stopped it.
  get isUnconfirmed() {
    return this.#since !== null && (!this.connection.connected || performance.now() - this.#since > shownAfter);
  }

  async #send() {
    clearTimeout(this.#timer);
    this.#newest += 1;
    const number = this.#newest;
    try {
      await this.connection.ask('emergency_stop', 'std_srvs/Trigger');
      if (number === this.#newest) this.forget(this.#presses);
    } catch {
      // Without a connection, the next one sends it.
      if (number === this.#newest && this.#since !== null && this.connection.connected)
        this.#timer = setTimeout(() => this.#send(), repeatAfter);
    }
  }
}
