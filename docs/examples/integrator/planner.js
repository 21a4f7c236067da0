// A planner in JavaScript without any package: the few parts of ZMTP 3.0 (rfc.zeromq.org/spec/23) and msgpack that it
// takes to receive obstacle lists. Prints a line of JSON for each. With the package zeromq it is ten lines, as in Python.
//
// node planner.js RUN_DIR LISTS
"use strict";
const net = require("net");

const [runDir, lists] = [process.argv[2], Number(process.argv[3])];

// One value of msgpack at `at`: [value, place behind it].
function unpack(b, at = 0) {
  const c = b[at++];
  const items = (n, read) => { const all = []; while (n-- > 0) { let v; [v, at] = read(); all.push(v); } return all; };
  const next = () => unpack(b, at);
  const pair = () => { const [k, behind] = unpack(b, at); const [v, end] = unpack(b, behind); return [[k, v], end]; };
  const list = (n) => [items(n, next), at];
  const map = (n) => [Object.fromEntries(items(n, pair)), at];
  const text = (n) => [b.toString("utf8", at, at + n), at + n];
  if (c < 0x80) return [c, at];
  if (c < 0x90) return map(c & 0x0f);
  if (c < 0xa0) return list(c & 0x0f);
  if (c < 0xc0) return text(c & 0x1f);
  if (c >= 0xe0) return [c - 256, at];
  switch (c) {
    case 0xc0: return [null, at];
    case 0xc2: return [false, at];
    case 0xc3: return [true, at];
    case 0xca: return [b.readFloatBE(at), at + 4];
    case 0xcb: return [b.readDoubleBE(at), at + 8];
    case 0xcc: return [b[at], at + 1];
    case 0xcd: return [b.readUInt16BE(at), at + 2];
    case 0xce: return [b.readUInt32BE(at), at + 4];
    case 0xcf: return [b.readBigUInt64BE(at), at + 8];
    case 0xd0: return [b.readInt8(at), at + 1];
    case 0xd1: return [b.readInt16BE(at), at + 2];
    case 0xd2: return [b.readInt32BE(at), at + 4];
    case 0xd3: return [b.readBigInt64BE(at), at + 8];
    case 0xd9: { const n = b[at++]; return text(n); }
    case 0xda: { const n = b.readUInt16BE(at); at += 2; return text(n); }
    case 0xdb: { const n = b.readUInt32BE(at); at += 4; return text(n); }
    case 0xdc: { const n = b.readUInt16BE(at); at += 2; return list(n); }
    case 0xdd: { const n = b.readUInt32BE(at); at += 4; return list(n); }
    case 0xde: { const n = b.readUInt16BE(at); at += 2; return map(n); }
    case 0xdf: { const n = b.readUInt32BE(at); at += 4; return map(n); }
    default: throw new Error(`msgpack byte 0x${c.toString(16)}`);
  }
}

const GREETING = Buffer.alloc(64);
GREETING[0] = 0xff; GREETING[9] = 0x7f; GREETING[10] = 3; GREETING.write("NULL", 12);
const READY = Buffer.from("\x05READY\x0bSocket-Type\x00\x00\x00\x03SUB", "latin1");
const SUBSCRIBE = Buffer.from("\x01obstacles", "latin1");
const [MORE, LONG, COMMAND] = [1, 2, 4];

const frame = (flags, body) => Buffer.concat([Buffer.from([flags, body.length]), body]);

let listeners = Buffer.alloc(0), greeted = false, parts = [], told = 0;

function tell(obstacle_list) {
  const positions = obstacle_list.obstacles.map((o) => o.position_ned);
  console.log(JSON.stringify({ valid: obstacle_list.valid, reasons: obstacle_list.reasons, positions }));
  if (++told === lists) process.exit(0);
}

function take(socket, data) {
  listeners = Buffer.concat([listeners, data]);
  if (!greeted && listeners.length >= 64) {
    greeted = true;
    listeners = listeners.subarray(64);
    socket.write(frame(COMMAND, READY));
    socket.write(frame(0, SUBSCRIBE));
  }
  while (greeted && listeners.length >= 2) {
    const flags = listeners[0], head = flags & LONG ? 9 : 2;
    if (listeners.length < head) return;
    const size = flags & LONG ? Number(listeners.readBigUInt64BE(1)) : listeners[1];
    if (listeners.length < head + size) return;
    const body = listeners.subarray(head, head + size);
    listeners = listeners.subarray(head + size);
    if (flags & COMMAND) continue;
    parts.push(Buffer.from(body));
    if (flags & MORE) continue;
    tell(unpack(parts[1])[0]);
    parts = [];
  }
}

const WHY = { EACCES: "no right to open the socket: join its group", ENOENT: "no socket: does the tracker run?",
  ECONNREFUSED: "no socket: does the tracker run?" };
let why = ""; // the newest reason, so that it is said once

function connect() { // until the tracker is there, and again when it has gone
  listeners = Buffer.alloc(0); greeted = false; parts = [];
  const socket = net.connect(`${runDir}/tracker.sock`, () => socket.write(GREETING));
  socket.on("data", (data) => take(socket, data));
  socket.on("error", (error) => { if (error.code !== why) console.error(`${runDir}/tracker.sock: ${WHY[why = error.code] ?? why}`); });
  socket.on("close", () => setTimeout(connect, 200));
}

connect();
