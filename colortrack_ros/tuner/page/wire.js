// The connection to the server: messages as JSON, pictures as bytes.

const listeners = {};
let socket = null;
let pause = 500;
let picture = null;

export function on(kind, listener) {
  listeners[kind] = listener;
}

export function send(command, fields = {}) {
  if (socket?.readyState !== WebSocket.OPEN) return false;
  socket.send(JSON.stringify({ do: command, ...fields }));
  return true;
}

export function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
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
      await listeners.view(await decoded(data));
    } finally {
      send('shown');
    }
  };
}

// Three lengths, then as many bytes of JSON, of a JPEG, none if the picture is the last one that came,
// and of a PNG whose grays are labels.
async function decoded(bytes) {
  const head = new DataView(bytes);
  const [json, jpeg, png] = [0, 4, 8].map((at) => head.getUint32(at, true));
  const view = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 12, json)));
  const exact = { colorSpaceConversion: 'none', premultiplyAlpha: 'none' };
  if (jpeg) picture = createImageBitmap(new Blob([new Uint8Array(bytes, 12 + json, jpeg)], { type: 'image/jpeg' }));
  [view.picture, view.mask] = await Promise.all([
    picture,
    createImageBitmap(new Blob([new Uint8Array(bytes, 12 + json + jpeg, png)], { type: 'image/png' }), exact),
  ]);
  return view;
}
