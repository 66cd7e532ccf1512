## One table of a report: caption, headings with their scope, rows that begin with their heading.
<%def name="table(t)">
<div class="scroll${' short' if len(t.rows) <= 8 else ''}" role="region" tabindex="0" aria-labelledby="${t.name}-caption">
<table id="${t.name}">
<caption id="${t.name}-caption"><span>${t.caption}</span></caption>
<thead><tr>
% for heading, numeric in t.columns:
<th scope="col"${' class="n"' if numeric else '' | n}>${heading}</th>
% endfor
</tr></thead>
<tbody>
% for row in t.rows:
<tr>
% for k, cell in enumerate(row):
% if k == 0:
<th scope="row">${cell}</th>
% else:
<td${' class="n"' if t.columns[k][1] else '' | n}>${cell}</td>
% endif
% endfor
</tr>
% endfor
</tbody>
</table>
</div>
% if t.note:
<p class="note">${t.note}</p>
% endif
</%def>
