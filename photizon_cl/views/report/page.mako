## The report: one page, no script, nothing from outside. Every ${value} is escaped by default.
<%namespace name="parts" file="table.mako"/>
<%def name="figure(f)">
<figure>
<img src="${f.source}" width="${f.size[0]}" height="${f.size[1]}" alt="${f.alt}">
<figcaption>${f.caption}</figcaption>
</figure>
</%def>
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="${generator}">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<link rel="icon" href="data:,">
<title>${title} – report</title>
<style>
${style}
</style>
</head>
<body>
<a class="skip" href="#main">Skip to the results</a>
<header>
<p class="over">Report of a run · ${scene_name}</p>
<h1>${title}</h1>
% for paragraph in summary:
<p class="lead">${paragraph}</p>
% endfor
</header>
<nav aria-label="Contents">
<ul>
<li><a href="#figures-at-a-glance">Key figures</a></li>
<li><a href="#advisories">Advisories</a></li>
<li><a href="#ledger">Ledger</a></li>
% if detectors:
<li><a href="#detectors">Detectors</a></li>
% endif
% if far_field:
<li><a href="#far-field">Far field</a></li>
% endif
% if checks:
<li><a href="#checks">Checks of σ</a></li>
% endif
% if tallies:
<li><a href="#tallies">Counted by effects</a></li>
% endif
% if others:
<li><a href="#more-figures">More figures</a></li>
% endif
<li><a href="#claims">What it does not claim</a></li>
<li><a href="#run">How it was run</a></li>
<li><a href="#effects">Effects</a></li>
<li><a href="#scene">Scene</a></li>
</ul>
</nav>
<main id="main" tabindex="-1">

<section aria-labelledby="figures-at-a-glance">
<h2 id="figures-at-a-glance">Key figures</h2>
<dl class="key">
% for name, value, remark in key_figures:
<div><dt>${name}</dt><dd>${value}
% if remark:
<small>${remark}</small>
% endif
</dd></div>
% endfor
</dl>
</section>

<section aria-labelledby="advisories">
<h2 id="advisories">Advisories</h2>
% if advisories:
<ul class="advice">
% for advisory in advisories:
<li>${advisory}</li>
% endfor
</ul>
% else:
<p>None: nothing in the run or in the scene asks for a second look.</p>
% endif
</section>

<section aria-labelledby="ledger">
<h2 id="ledger">Where the power went</h2>
${parts.table(ledger)}
% for f in figures.of("ledger"):
${figure(f)}
% endfor
% if by_wavelength:
<section aria-labelledby="by-wavelength">
<h3 id="by-wavelength">By wavelength</h3>
${parts.table(by_wavelength)}
% for f in figures.of("by-wavelength"):
${figure(f)}
% endfor
</section>
% endif
</section>

% if detectors:
<section aria-labelledby="detectors">
<h2 id="detectors">Detectors</h2>
${parts.table(detectors)}
% for section in sections:
<section aria-labelledby="${section.anchor}">
<h3 id="${section.anchor}">${section.name}</h3>
% if section.map:
${parts.table(section.map)}
% endif
% for f in section.figures:
% if f.kind in ("map", "sigma"):
${figure(f)}
% endif
% endfor
% if section.ladder:
${parts.table(section.ladder)}
% endif
% for f in section.figures:
% if f.kind == "ladder":
${figure(f)}
% endif
% endfor
% if section.paths:
${parts.table(section.paths)}
% endif
% for f in section.figures:
% if f.kind in ("paths", "ghosts"):
${figure(f)}
% endif
% endfor
</section>
% endfor
% if more_detectors != "0":
<p class="note">Maps and ladders of ${more_detectors} further detectors are in <code>result.nc</code>.</p>
% endif
</section>
% endif

% if far_field:
<section aria-labelledby="far-field">
<h2 id="far-field">Far field</h2>
% for each in far_field:
${parts.table(each)}
% endfor
% for f in figures.of("far-field-theta", "far-field", "far-field-cuts"):
${figure(f)}
% endfor
</section>
% endif

% if checks:
<section aria-labelledby="checks">
<h2 id="checks">Can σ be believed?</h2>
${parts.table(checks)}
</section>
% endif

% if tallies:
<section aria-labelledby="tallies">
<h2 id="tallies">Counted by effects</h2>
% for tally in tallies:
${parts.table(tally)}
% endfor
</section>

% endif
% if others:
<section aria-labelledby="more-figures">
<h2 id="more-figures">More figures</h2>
% for f in others:
${figure(f)}
% endfor
</section>
% endif

% if figures.left_out or figures.failed:
<section aria-labelledby="missing-figures">
<h2 id="missing-figures">Figures that are not on this page</h2>
<ul>
% for name in figures.left_out:
<li><code>figures/${name}</code>: kept as a file, so that the page stays small.</li>
% endfor
% for name, why in figures.failed:
<li><code>${name}</code> could not be drawn: ${why}</li>
% endfor
</ul>
</section>
% endif

<section aria-labelledby="claims">
<h2 id="claims">What this run does not claim</h2>
<ul>
% for claim in claims:
<li>${claim}</li>
% endfor
</ul>
</section>

<section aria-labelledby="run">
<h2 id="run">How it was run</h2>
${parts.table(run)}
% for f in figures.of("convergence"):
${figure(f)}
% endfor
% if recipe is not None:
<h3 id="recipe">Recipe</h3>
<p>This token reproduces the run bit for bit: <code>photizon run --recipe TOKEN</code>.</p>
<pre class="token">${recipe}</pre>
% endif
${parts.table(versions)}
</section>

% if study is not None:
<section aria-labelledby="cost">
<h2 id="cost">What accuracy costs</h2>
${parts.table(cost)}
% for f in figures.of("cost"):
${figure(f)}
% endfor
% if study.advice:
<ul>
% for text in study.advice:
<li>${text}</li>
% endfor
</ul>
% endif
</section>

% endif
<section aria-labelledby="effects">
<h2 id="effects">Effects</h2>
${parts.table(effects)}
${parts.table(left_out)}
</section>

<section aria-labelledby="scene">
<h2 id="scene">The scene as run</h2>
% if notes:
<p class="notes">${notes}</p>
% endif
% for f in figures.of("layout"):
${figure(f)}
% endfor
<details>
<summary>The scene file (TOML): lengths in metres, powers in watts</summary>
<pre class="scene">${scene}</pre>
% if scene_left:
<p class="note">${scene_left} further characters are left out here; <code>scene.toml</code> beside the result has all of it.</p>
% endif
</details>
</section>
</main>
<footer>
<p>Written by ${generator}. This page is complete in itself: it loads nothing and runs no script.</p>
</footer>
</body>
</html>
