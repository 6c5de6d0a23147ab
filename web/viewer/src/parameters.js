// The program's parameters as last received. The page displays these, never its own pending requests.

const isObject = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);

// Merges `changes` into the pending request.
function merged(before, changes) {
  const both = ([name, value]) => [name, isObject(value) ? { ...before[name], ...value } : value];
  return { ...before, ...Object.fromEntries(Object.entries(changes).map(both)) };
}

export class Parameters {
  current = null;
  #listeners = new Set();
  #pending = null; // changes to send after the response to the last request
  #sending = false;

  constructor(connection, onRefusal) {
    this.connection = connection;
    this.onRefusal = onRefusal;
    connection.subscribe('parameters', 'std_msgs/String', ({ data }) => this.#receive(data));
  }

  onChange(listener) {
    this.#listeners.add(listener);
    if (this.current) listener(this.current);
  }

  /// Requests `changes`. During a request, further changes are merged and sent after it. Of an object, such as the
  /// filter, only the given members change.
  set(changes) {
    this.#pending = merged(this.#pending ?? {}, changes);
    if (!this.#sending) this.#send();
  }

  async #send() {
    this.#sending = true;
    while (this.#pending) {
      const changes = this.#pending;
      this.#pending = null;
      try {
        await this.connection.ask('set_parameters', 'palpate/SetParameters', { json: JSON.stringify(changes) });
      } catch (error) {
        this.onRefusal(error.message);
        this.#notify(); // resets the fields to the current values
      }
    }
    this.#sending = false;
  }

  #receive(text) {
    this.current = JSON.parse(text);
    this.#notify();
  }

  #notify() {
    if (this.current) for (const listener of this.#listeners) listener(this.current);
  }
}
