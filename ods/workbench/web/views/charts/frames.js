// The page's link to the server: images of all views come over one WebSocket, pulled: the next is asked for once the last
// is drawn, and shown. A view has a `channel`, and: isShown(), have(), wantedCells(), show(frame), drawIfNew().

const views = new Set();
let socket = null;

export function joinLink(view) {
  views.add(view);
  request();
}

export function leaveLink(view) {
  views.delete(view);
}

export function request() {
  if (!views.size) return;
  if (socket === null || socket.readyState > WebSocket.OPEN) return connect();
  if (socket.readyState !== WebSocket.OPEN) return;
  const wanted = {};
  for (const view of views) if (view.isShown()) wanted[view.channel] = { have: view.have(), cells: view.wantedCells() };
  socket.send(JSON.stringify({ views: wanted }));
}

function connect() {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  socket = new WebSocket(`${scheme}//${location.host}/frames`);
  socket.binaryType = "arraybuffer";
  socket.onopen = request;
  socket.onmessage = (event) => take(event.data);
  socket.onclose = () => setTimeout(request, 1000);
}

function take(message) {
  const length = new DataView(message).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(message, 4, length)));
  let at = 4 + length;
  for (const frame of header.views) {
    const size = frame.beams * frame.cells;
    frame.data = new Uint8Array(message, at, size);
    at += size;
    if (frame.attention) {
      frame.attended = new Uint8Array(message, at, size);
      at += size;
    }
    for (const view of views) if (view.channel === frame.key) view.show(frame);
  }
  for (const view of views) view.drawIfNew(); // at once: it need not wait for a frame, only be there for the next
  requestAnimationFrame(request);
}
