  // What all parts of the script use: the data of the page, and its elements.
  // Names are keys: an object that inherits nothing has no other ones, such as "constructor".
  const bare = (key, value) =>
    value && typeof value === "object" && !Array.isArray(value) ? Object.assign(Object.create(null), value) : value;
  const data = JSON.parse(document.getElementById("data").textContent, bare);
  const byId = (id) => document.getElementById(id);
  const make = (tag, text) => Object.assign(document.createElement(tag), { textContent: text });

