## The report of a sweep: one page, no script, nothing from outside. Every value is escaped.
<%namespace name="parts" file="table.mako"/>
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="${generator}">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<link rel="icon" href="data:,">
<title>${title} – report of a sweep</title>
<style>
${style}
</style>
</head>
<body>
<a class="skip" href="#main">Skip to the results</a>
<header>
<p class="over">Report of a sweep · ${scene_name}</p>
<h1>${title}</h1>
% for paragraph in summary:
<p class="lead">${paragraph}</p>
% endfor
</header>
<nav aria-label="Contents">
<ul>
<li><a href="#measured">What was measured</a></li>
<li><a href="#points">Points</a></li>
<li><a href="#changes">Changes</a></li>
<li><a href="#runs">How each was run</a></li>
</ul>
</nav>
<main id="main" tabindex="-1">

<section aria-labelledby="measured">
<h2 id="measured">What was measured</h2>
<dl class="key">
% for name, meaning in measures:
<div><dt>${name}</dt><dd><small>${meaning}</small></dd></div>
% endfor
</dl>
% if advisories:
<ul class="advice">
% for text in advisories:
<li>${text}</li>
% endfor
</ul>
% endif
% if drawing:
<figure>
<img src="${drawing.source}" width="${drawing.size[0]}" height="${drawing.size[1]}" alt="${drawing.alt}">
<figcaption>${drawing.caption}</figcaption>
</figure>
% endif
</section>

<section aria-labelledby="points">
<h2 id="points">Points</h2>
${parts.table(points)}
% if failed:
<ul class="advice">
% for text in failed:
<li>${text}</li>
% endfor
</ul>
% endif
</section>

<section aria-labelledby="changes">
<h2 id="changes">Changes against the first point</h2>
${parts.table(changes)}
</section>

<section aria-labelledby="runs">
<h2 id="runs">How each was run</h2>
${parts.table(runs)}
% if notes:
<p>${notes}</p>
% endif
</section>

</main>
</body>
</html>
