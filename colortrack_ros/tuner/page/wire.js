// The connection to the server: messages as JSON, pictures as bytes.

const AS_BEFORE = 0xffffffff; // in place of the length of a JPEG: the last one that came
const listeners = {};
let socket = null;
let pause = 500;
let file = null; // the last JPEG
let picture = null; // what it shows, once it is decoded

export function on(kind, listener) {
  listeners[kind] = listener;
}

export function send(command, fields = {}) {
  if (socket?.readyState !== WebSocket.OPEN) return false;
  socket.send(JSON.stringify({ do: command, ...fields }));
  return true;
}

export function connect() {
  const own = new WebSocket(`ws://${location.host}/socket`);
  socket = own;
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => { pause = 500; listeners.link(true); };
  socket.onclose = () => {
    listeners.link(false);
    setTimeout(connect, pause);
    pause = Math.min(pause * 2, 5000);
  };
  socket.onmessage = async ({ data }) => {
    if (typeof data === 'string') {
      const message = JSON.parse(data);
      listeners[message.is]?.(message);
      return;
    }
    try {
      const view = await decoded(data);
      if (own === socket) await listeners.view(view); // else the next connection has shown a later one
    } finally {
      if (own === socket) send('shown');
    }
  };
}

// Three lengths, then as many bytes of JSON, of a JPEG, and of a PNG whose grays are labels.
async function decoded(bytes) {
  const head = new DataView(bytes);
  const [json, length, png] = [0, 4, 8].map((at) => head.getUint32(at, true));
  const jpeg = length === AS_BEFORE ? 0 : length;
  const view = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 12, json)));
  const exact = { colorSpaceConversion: 'none', premultiplyAlpha: 'none' };
  if (length === AS_BEFORE) {
    picture = picture.catch(() => createImageBitmap(file));
  } else {
    file = new Blob([new Uint8Array(bytes, 12 + json, jpeg)], { type: 'image/jpeg' });
    picture = createImageBitmap(file);
  }
  [view.picture, view.mask] = await Promise.all([
    picture,
    createImageBitmap(new Blob([new Uint8Array(bytes, 12 + json + jpeg, png)], { type: 'image/png' }), exact),
  ]);
  return view;
}
