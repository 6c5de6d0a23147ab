// The program's parameters as it last told them. What the page shows follows these, never its own wishes.

const isObject = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);

// `changes` on top of what was asked for before.
function merged(before, changes) {
  const both = ([name, value]) => [name, isObject(value) ? { ...before[name], ...value } : value];
  return { ...before, ...Object.fromEntries(Object.entries(changes).map(both)) };
}

export class Parameters {
  current = null;
  #listeners = new Set();
  #pending = null; // what to send when the answer to the last change is here
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

  /// Asks for `changes`; while an answer is awaited, later changes are put together and sent after it. Of an object,
  /// such as the filter, the program changes what is named.
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
        this.#notify(); // the fields go back to what is
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
