// The connection to the server, which is opened again when it is lost.

import { Picture } from "./picture.js";

const FIRST_WAIT = 500;
const LONGEST_WAIT = 4000;

export class Connection {
  // `on` has functions for the types of messages, and `picture`, `up` and `down`.
  constructor(on) {
    this.on = on;
    this.wait = FIRST_WAIT;
    this.next = 1;
    this.waiting = new Map();
    this.open();
  }

  open() {
    const place = new URL("socket", document.baseURI);
    place.protocol = place.protocol.replace("http", "ws");
    place.search = "";
    const socket = new WebSocket(place);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait = FIRST_WAIT;
      this.on.up();
    };
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.read(JSON.parse(data)) : this.show(data));
    socket.onclose = () => {
      this.waiting.clear();
      this.on.down();
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, LONGEST_WAIT);
    };
    this.socket = socket;
  }

  read(message) {
    const answer = this.waiting.get(message.id);
    if (answer) {
      this.waiting.delete(message.id);
      answer(message);
    } else {
      this.on[message.type]?.(message);
    }
  }

  show(buffer) {
    const picture = Picture.read(buffer);
    if (picture) this.on.picture(picture);
    // The next picture may come once this one is on the screen.
    requestAnimationFrame(() => this.send({ type: "ack" }));
    if (document.hidden) this.send({ type: "ack" });
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  send(message) {
    if (this.isOpen) this.socket.send(JSON.stringify(message));
  }

  // Sends a message that is answered; the promise may never be kept if the connection is lost.
  ask(message) {
    return new Promise((answer) => {
      const id = this.next++;
      this.waiting.set(id, answer);
      this.send({ ...message, id });
    });
  }
}
