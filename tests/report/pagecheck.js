// What is looked for inside a page. Each function returns one line for every fault.

const tagged = e => `<${e.tagName.toLowerCase()}> "${e.textContent.trim().slice(0, 40)}"`;

function structure() {
  const out = [];
  if (document.compatMode !== 'CSS1Compat') out.push('quirks mode: no doctype');
  if (!document.documentElement.lang) out.push('no lang');
  if (!document.title.trim()) out.push('no title');
  for (const tag of ['main', 'h1'])
    if (document.querySelectorAll(tag).length !== 1) out.push(`not exactly one <${tag}>`);
  if (document.querySelector('script')) out.push('a script');
  let level = 0;
  for (const h of document.querySelectorAll('h1, h2, h3, h4, h5, h6')) {
    const now = Number(h.tagName[1]);
    if (now > level + 1) out.push(`heading order: ${tagged(h)} after level ${level}`);
    if (!h.textContent.trim()) out.push('an empty heading');
    level = now;
  }
  const ids = new Set();
  for (const e of document.querySelectorAll('[id]')) {
    if (ids.has(e.id)) out.push(`id twice: ${e.id}`);
    ids.add(e.id);
  }
  for (const a of document.querySelectorAll('a[href^="#"]'))
    if (!ids.has(a.getAttribute('href').slice(1))) out.push(`link to nowhere: ${tagged(a)}`);
  for (const e of document.querySelectorAll('[aria-labelledby]'))
    if (!ids.has(e.getAttribute('aria-labelledby'))) out.push(`label to nowhere: ${tagged(e)}`);
  const first = document.querySelector('a, button, summary, [tabindex="0"]');
  if (!first || first.getAttribute('href') !== '#main') out.push('no skip link first');
  for (const img of document.images) {
    if (!(img.getAttribute('alt') || '').trim()) out.push('an image without alt text');
    if (!img.complete || !img.naturalWidth) out.push(`image not shown: "${img.alt.slice(0, 40)}"`);
  }
  const widths = new Set([...document.querySelectorAll('figure img')].map(
    img => Math.round(img.getBoundingClientRect().width)));
  if (widths.size > 1) out.push(`figures of unequal widths: ${[...widths].join(', ')} px`);
  for (const f of document.querySelectorAll('figure'))
    if (!f.querySelector('figcaption')) out.push('a figure without caption');
  for (const t of document.querySelectorAll('table')) out.push(...tableFaults(t));
  return out;
}

function tableFaults(t) {
  const out = [];
  if (!t.caption || !t.caption.textContent.trim()) out.push(`table without caption: ${tagged(t)}`);
  if (!t.tHead || !t.tBodies.length || !t.tBodies[0].rows.length)
    return [...out, `table without head or rows: ${tagged(t)}`];
  for (const th of t.querySelectorAll('th'))
    if (!['col', 'row'].includes(th.getAttribute('scope'))) out.push(`heading without scope: ${tagged(th)}`);
  for (const th of t.tHead.querySelectorAll('th'))
    if (!th.textContent.trim()) out.push(`empty heading: ${tagged(t)}`);
  for (const row of t.tBodies[0].rows) {
    if (row.cells.length !== t.rows[0].cells.length) out.push(`uneven row: ${tagged(row)}`);
    if (row.cells[0].tagName !== 'TH') out.push(`row without heading: ${tagged(row)}`);
  }
  return out;
}

// Text is readable at a ratio of 4.5, large text at 3 (WCAG 2.2, 1.4.3): large is 24 px, or 18.66
// px in bold.
function contrast() {
  const parse = s => {
    const m = s.match(/[\d.]+/g).map(Number);
    return [m[0], m[1], m[2], m.length > 3 ? m[3] : 1];
  };
  const over = (a, b) => [0, 1, 2].map(i => a[i] * a[3] + b[i] * (1 - a[3]));
  const luminance = colour => {
    const [r, g, b] = colour.slice(0, 3).map(v => {
      v /= 255;
      return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = e => {
    const layers = [];
    for (let p = e; p; p = p.parentElement) layers.push(parse(getComputedStyle(p).backgroundColor));
    return layers.reverse().reduce((below, colour) => over(colour, below), [255, 255, 255]);
  };
  const out = new Set();
  let seen = 0;
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const node = walk.currentNode, e = node.parentElement;
    if (!node.data.trim() || !e.checkVisibility({ visibilityProperty: true })) continue;
    const style = getComputedStyle(e), paper = behind(e), ink = parse(style.color);
    for (let p = e; p; p = p.parentElement) ink[3] *= Number(getComputedStyle(p).opacity);
    const [a, b] = [luminance(over(ink, paper)), luminance(paper)].sort((x, y) => y - x);
    const size = parseFloat(style.fontSize), bold = Number(style.fontWeight) >= 700;
    const needed = size >= 24 || (bold && size >= 18.66) ? 3 : 4.5;
    const ratio = (a + 0.05) / (b + 0.05);
    seen += 1;
    if (ratio < needed) out.add(`contrast ${ratio.toFixed(2)} of ${tagged(e)}`);
  }
  return seen ? [...out] : ['no text to see'];
}

function overflow() {
  const room = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth <= room) return [];
  const wide = [...document.body.querySelectorAll('*')].filter(
    e => e.getBoundingClientRect().right > room + 1 && !e.closest('.scroll'));
  return [`wider than ${room} px: ${wide.slice(0, 3).map(tagged).join(', ')}`];
}

function paper() {
  const out = [], ground = getComputedStyle(document.body).backgroundColor;
  if (!['rgb(255, 255, 255)', 'rgba(0, 0, 0, 0)'].includes(ground)) out.push(`paper is ${ground}`);
  for (const e of document.querySelectorAll('details > :not(summary)'))
    if (!e.checkVisibility()) out.push(`stays folded away: ${tagged(e)}`);
  for (const e of document.querySelectorAll('tr, figure'))
    if (getComputedStyle(e).breakInside !== 'avoid')
      return [...out, `may be split between pages: ${tagged(e)}`];
  return out;
}

function unfold(open = true) {
  for (const d of document.querySelectorAll('details')) d.open = open;
  return [];
}

function fold() {
  return unfold(false);
}
