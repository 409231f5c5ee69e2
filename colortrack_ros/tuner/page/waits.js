// How long people wait for the picture that shows what they did.

let begun = 0;
let asked = []; // [revision of the settings, when somebody asked for it]

// Somebody does something that changes the settings.
export function begin() {
  begun ||= performance.now();
}

// The server says which revision that is.
export function expect(revision) {
  if (begun) asked.push([revision, begun]);
  begun = 0;
}

// It is refused.
export function forget() {
  begun = 0;
}

// A picture is shown; the longest wait that it ends [ms], 0 for none.
export function end(revision) {
  const waited = asked.filter(([wanted]) => wanted <= revision).map(([, when]) => performance.now() - when);
  asked = asked.filter(([wanted]) => wanted > revision);
  return Math.max(0, ...waited);
}
