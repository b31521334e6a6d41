/**
 * The link to the simulator: one WebSocket that comes back by itself.
 *
 * Sequence numbers of commands rise as long as the page lives, also over a reconnection. Events: one for each message,
 * named by its type, with the message as `detail`; `up` and `down`.
 */
const FIRST_WAIT_MS = 300;
const LONGEST_WAIT_MS = 3000;
const FULL = 65536; // bytes waiting in the socket: the link has stalled, a command in there would be old on arrival

export class Link extends EventTarget {
  #socket = null;
  #sequence = 0;
  #wait = FIRST_WAIT_MS;
  #timer = 0;

  constructor(url = Link.address()) {
    super();
    this.url = url;
    this.lastSent = null;
    this.heard = 0; // the page's clock at the last message [ms]
    addEventListener("online", () => this.#again(0));
    this.#open();
  }

  static address() {
    return `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/socket`;
  }

  get up() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /** Send a message; false where there is no link. */
  send(message) {
    if (!this.up) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  /** Send the claw's command, with its number and the page's clock. */
  command({ along, across, device }, shown) {
    if (!this.up || this.#socket.bufferedAmount > FULL) return false;
    const message = {
      type: "command", sequence: ++this.#sequence, stamp_ms: performance.now(), along, across, device, shown,
    };
    this.lastSent = message;
    return this.send(message);
  }

  #open() {
    clearTimeout(this.#timer);
    const socket = new WebSocket(this.url);
    this.#socket = socket;
    socket.onopen = () => {
      this.#wait = FIRST_WAIT_MS;
      this.heard = performance.now();
      this.dispatchEvent(new Event("up"));
    };
    socket.onmessage = (event) => this.#take(event.data);
    socket.onclose = () => {
      if (socket !== this.#socket) return;
      this.dispatchEvent(new Event("down"));
      this.#again(this.#wait);
      this.#wait = Math.min(LONGEST_WAIT_MS, 1.7 * this.#wait);
    };
  }

  #again(wait) {
    if (this.up || this.#socket?.readyState === WebSocket.CONNECTING) return;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#open(), wait);
  }

  #take(text) {
    let message;
    try {
      message = JSON.parse(text);
    } catch {
      return; // not ours
    }
    this.heard = performance.now();
    if (typeof message?.type === "string") this.dispatchEvent(new CustomEvent(message.type, { detail: message }));
  }
}
