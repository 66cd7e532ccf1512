## What a notebook shows of a result: no script, no style sheet, nothing from outside. Colours are
## those of the notebook, so that it reads in dark ones too.
<%def name="table(t)">
<table style="border-collapse: collapse; margin: 0.5em 0; color: inherit; background: transparent">
<caption style="caption-side: top; text-align: left; color: inherit">${t.caption}</caption>
<thead><tr>
% for heading, numeric in t.columns:
<th scope="col" style="padding: 0.15em 0.6em; text-align: ${'right' if numeric else 'left'}">${heading}</th>
% endfor
</tr></thead>
<tbody>
% for row in t.rows:
<tr>
% for k, cell in enumerate(row):
% if k == 0:
<th scope="row" style="padding: 0.15em 0.6em; text-align: left; font-weight: normal">${cell}</th>
% else:
<td style="padding: 0.15em 0.6em; text-align: ${'right' if t.columns[k][1] else 'left'}">${cell}</td>
% endif
% endfor
</tr>
% endfor
</tbody>
</table>
% if t.note:
<div style="opacity: 0.8">${t.note}</div>
% endif
</%def>
<div class="photizon-result">
<div><strong>${title}</strong></div>
<div>${head}</div>
${table(ledger)}
% if detectors:
${table(detectors)}
% endif
% for tally in tallies:
${table(tally)}
% endfor
% if advisories:
<div>${advisories}</div>
% endif
</div>
