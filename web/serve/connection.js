// SPDX-License-Identifier: Apache-2.0
// The line to the server: events bring what it knows, requests carry what a person wants.

/** The only thing that a browser keeps: with the key it still has the controls after a reload. */
const keyName = "panelcal-controls";
/** Without an event for this long the server is asked whether it is there. */
const longestSilence_ms = 10000;
const longestAnswer_ms = 4000;
const pause_ms = 1000;

/** What the server says of a request that it refuses. */
export class Refusal extends Error {
  /**
   * @param {{what?: string, expected?: string}} said
   * @param {number} status
   */
  constructor(said, status) {
    super(said.what ?? `HTTP ${status}`);
    this.expected = said.expected ?? "";
  }
}

/**
 * @typedef {"connecting" | "open" | "lost" | "locked"} Condition locked: a token is asked for
 * @typedef {{state: (document: any) => void, frame: (number: number) => void, controls: (controls: any) => void,
 *            condition: (condition: Condition) => void}} Listener
 */

export class Connection {
  /** @param {Listener} listener */
  constructor(listener) {
    this.listener = listener;
    /** @type {EventSource | null} */
    this.stream = null;
    /** Answers to a request before the last one do not count. */
    this.attempt = 0;
    this.heard_ms = 0;
    /** A token was asked for. */
    this.hasSession = false;
    setInterval(() => {
      if (this.stream && Date.now() - this.heard_ms > longestSilence_ms) this.ask(this.attempt);
    }, pause_ms);
  }

  get key() {
    return sessionStorage.getItem(keyName) ?? "";
  }

  /** The part of the key that names this screen's stream, and gives no right: addresses are noted on their way. */
  get streamName() {
    return this.key.split(".")[1] ?? "";
  }

  /** Opens the line, or opens it anew. */
  async open() {
    const attempt = ++this.attempt;
    this.stream?.close();
    this.stream = null;
    if (!await this.ask(attempt)) return;
    const stream = new EventSource(this.key ? `api/events?stream=${encodeURIComponent(this.streamName)}` : "api/events");
    this.stream = stream;
    const listen = (/** @type {string} */ name, /** @type {(said: any) => void} */ hear) =>
      stream.addEventListener(name, (event) => {
        this.heard_ms = Date.now();
        hear(JSON.parse(/** @type {MessageEvent} */ (event).data));
      });
    listen("state", (said) => this.listener.state(said));
    listen("frame", (said) => this.listener.frame(said.number));
    listen("controls", ({ controls }) => {
      if (!controls.mine) sessionStorage.removeItem(keyName);
      this.listener.controls(controls);
    });
    stream.addEventListener("error", () => {
      if (this.stream === stream) this.lose(attempt);
    });
  }

  /**
   * Asks for the state: says whether the server answers.
   * @param {number} attempt
   */
  async ask(attempt) {
    this.heard_ms = Date.now();
    try {
      const response = await fetch("api/state", { signal: /** @type {any} */ (AbortSignal).timeout(longestAnswer_ms), cache: "no-store" });
      if (attempt !== this.attempt) return false;
      if (response.status === 401) {
        this.listener.condition("locked");
        return false;
      }
      if (!response.ok) throw new Refusal({}, response.status);
      this.hasSession = response.headers.has("X-Panelcal-Session");
      const document = await response.json();
      if (attempt !== this.attempt) return false;
      this.listener.condition("open");
      this.listener.state(document);
      return true;
    } catch {
      this.lose(attempt);
      return false;
    }
  }

  /** @param {number} attempt */
  lose(attempt) {
    if (attempt !== this.attempt) return;
    this.stream?.close();
    this.stream = null;
    this.listener.condition("lost");
    setTimeout(() => {
      if (attempt === this.attempt) this.open();
    }, pause_ms);
  }

  /**
   * Sends a request that changes something; throws a Refusal, or what the network says.
   * @param {string} path
   * @param {any} body an object, or a file
   */
  async send(path, body) {
    const isFile = body instanceof Blob;
    const response = await fetch(path, {
      method: "POST", body: isFile ? body : JSON.stringify(body),
      headers: { "Content-Type": isFile ? "application/octet-stream" : "application/json", "X-Panelcal-Controls": this.key },
    });
    const answer = await response.json().catch(() => ({}));
    if (!response.ok) throw new Refusal(answer.error ?? {}, response.status);
    return answer;
  }

  /** @param {string} token */
  async login(token) {
    await this.send("api/login", { token });
    await this.open();
  }

  /**
   * Takes the controls for a person; the stream then says whose they are.
   * @param {string} name
   * @param {string | null | undefined} from who has them now
   */
  async take(name, from) {
    const { key } = await this.send("api/controls", from ? { name, take: true, from } : { name, take: true });
    sessionStorage.setItem(keyName, key);
    await this.open();
  }

  /** Gives the controls back, and ends the session if that is wanted.
   * @param {boolean} isOver */
  async leave(isOver) {
    await (isOver ? this.send("api/logout", {}) : this.send("api/controls", { take: false }));
    sessionStorage.removeItem(keyName);
    await this.open();
  }
}
